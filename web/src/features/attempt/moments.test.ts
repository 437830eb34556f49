import assert from "node:assert/strict";
import { test } from "node:test";
import type { Annotation, Series } from "../../api/types";
import { boundLine, marksOf, secondsOfTick, stepOfTick, tickAt, tickOfStep } from "./moments";

const series = {
  rate_hz: 1000,
  step_ticks: 24,
  t_s: Array.from({ length: 101 }, (_, i) => i * 0.024),
} as unknown as Series;
const remark = (tick: number, createdMs: number) =>
  ({ id: `${tick}`, tick, created_ms: createdMs }) as unknown as Annotation;

test("a step's tick is in that step, and ticks beyond the end are in the last one", () => {
  for (const step of [0, 1, 57, 100]) assert.equal(stepOfTick(series, tickOfStep(series, step)), step);
  assert.equal(stepOfTick(series, 1e9), 100);
  assert.equal(secondsOfTick(series, 1500), 1.5);
});

test("a moment's tick leads back to that moment: at the beginning, within a step, after a gap and at the end", () => {
  const gap = { rate_hz: 1000, step_ticks: 100, t_s: [0, 0.1, 0.5, 0.6] } as unknown as Series;
  for (const at of [0, 0.013, 0.1, 0.199, 0.5, 0.555, 0.6, 0.643, 0.7])
    assert.ok(Math.abs(secondsOfTick(gap, tickAt(gap, at)) - at) < 1e-9, String(at));
  assert.equal(tickAt(gap, 0.643), 343, "of the ticks that were recorded");
  assert.equal(tickAt(gap, 0.35), 200, "in the gap");
  assert.equal(tickAt(gap, 9), 400);
});

test("remarks are numbered in order of time and lie along the timeline", () => {
  const marks = marksOf(series, [remark(2400, 1), remark(0, 2), remark(1200, 9), remark(1200, 3)]);
  assert.deepEqual(
    marks.map((mark) => mark.number),
    [1, 2, 3, 4],
  );
  assert.deepEqual(
    marks.map((mark) => mark.share),
    [0, 0.5, 0.5, 1],
  );
  assert.equal(marks[1]?.annotation.created_ms, 3);
});

test("the device's limit is drawn where the force came near it, and not before it was known", () => {
  assert.deepEqual(boundLine({ bound_n: [0, 3, 3], force_n: [0, 1, 2.9] }), [null, 3, 3]);
  assert.equal(boundLine({ bound_n: [0, 7.9, 7.9], force_n: [0, 1, 2] }), undefined);
  assert.equal(boundLine({ bound_n: [0, 0], force_n: [0, 0] }), undefined);
});
