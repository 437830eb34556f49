import assert from "node:assert/strict";
import { test } from "node:test";
import type { Deduction, Mistake } from "../../api/types";
import { deductionsOf, deductionText, placeOf } from "./deductions";

const stroke = (number: number) => ({ number, first_tick: 72_000, first_s: 72.4, volume_mm3: 0.2 });
const deduction = (changes: Partial<Deduction> = {}): Deduction => ({
  mistake: 0,
  left: false,
  volume_mm3: 0.42,
  position_mm: [1, 0, 0],
  facing: [1, 0, 0],
  first_tick: 72_000,
  first_s: 72.4,
  stroke_count: 3,
  strokes: [stroke(7), stroke(8), stroke(9)],
  ...changes,
});

test("a deduction says how much, when it began and which strokes did it", () => {
  assert.equal(deductionText(deduction()), "0.42\u00a0mm³ too much, from 1:12.4; mostly stroke 7 and 2 more");
  assert.equal(
    deductionText(deduction({ stroke_count: 1, strokes: [stroke(7)] })),
    "0.42\u00a0mm³ too much, from 1:12.4; mostly stroke 7",
  );
  assert.equal(deductionText(deduction({ left: true, stroke_count: 0, strokes: [] })), "0.42\u00a0mm³ left uncut");
  assert.equal(deductionText(deduction({ stroke_count: 0, strokes: [] })), "0.42\u00a0mm³ too much");
});

test("a mistake's deductions have most volume first, and leave out what nobody sees", () => {
  const deductions = [
    deduction({ volume_mm3: 0.1 }),
    deduction({ volume_mm3: 0.5, left: true }),
    deduction({ volume_mm3: 0.001 }),
    deduction({ mistake: 1 }),
  ];
  assert.deepEqual(
    deductionsOf({ deductions }, 0).map((each) => each.volume_mm3),
    [0.5, 0.1],
  );
  assert.deepEqual(deductionsOf({ deductions }, 2), []);
});

test("a mistake without a volume is shown where it cost, and one without a place is not", () => {
  const mistake = (at_mm: Mistake["at_mm"]) => ({ at_mm }) as Mistake;
  const mistakes = [mistake([1, 2, 3]), mistake([0, 0, 0])];
  assert.deepEqual(placeOf({ mistakes }, 0), { position_mm: [1, 2, 3], first_tick: 0, stroke_count: 0 });
  assert.equal(placeOf({ mistakes }, 1), undefined);
  assert.equal(placeOf({ mistakes }, 2), undefined);
});
