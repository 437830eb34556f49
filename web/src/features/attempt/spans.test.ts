import assert from "node:assert/strict";
import { test } from "node:test";
import type { Deduction, Series } from "../../api/types";
import { nextMark, spansOf } from "./spans";

const series = {
  rate_hz: 1000,
  step_ticks: 100,
  t_s: [0, 0.1, 0.2, 0.3, 0.4],
  force_n: [0, 1, 3, 1, 0],
  force_mean_n: [0, 0.5, 0.5, 0.01, 0.2],
  late_ticks: [0, 0, 0, 0, 0],
  bound_n: [0, 3, 3, 3, 3],
} as unknown as Series;
const deduction = (left: boolean, ...moments: number[]) =>
  ({
    left,
    strokes: moments.map((at, i) => ({ number: i + 1, first_tick: 1000 * at, first_s: at, volume_mm3: 1 })),
  }) as unknown as Deduction;

test("contact, the device's limit, gaps and strokes that took too much stand where they were", () => {
  const spans = spansOf(
    series,
    [{ frames: 3, seconds: 0.25, endS: 0.4 }],
    [deduction(false, 0.3), deduction(true, 0.1), deduction(false, 0.3)],
  );
  const rounded = spans.map(({ kind, fromS, toS }) => `${kind} ${fromS.toFixed(2)} ${toS.toFixed(2)}`);
  assert.deepEqual(rounded, [
    "contact 0.10 0.30",
    "gap 0.15 0.40",
    "limit 0.20 0.30",
    "lost 0.30 0.30",
    "contact 0.40 0.50",
  ]);
});

test("one goes from mark to mark both ways, and contact is none", () => {
  const spans = spansOf(series, [], [deduction(false, 0.35)]);
  assert.equal(nextMark(spans, 0, 1), 0.2);
  assert.equal(nextMark(spans, 0.2, 1), 0.35, "not the one that one is at");
  assert.equal(nextMark(spans, 0.35, -1), 0.2);
});

test("after the last mark comes the first, since an attempt opens at its end", () => {
  const spans = spansOf(series, [], [deduction(false, 0.35)]);
  assert.equal(nextMark(spans, 0.5, 1), 0.2);
  assert.equal(nextMark(spans, 0.1, -1), 0.35);
  assert.equal(
    nextMark(
      spans.filter(({ kind }) => kind === "contact"),
      0.5,
      1,
    ),
    undefined,
  );
});
