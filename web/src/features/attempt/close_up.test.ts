import assert from "node:assert/strict";
import { test } from "node:test";
import type { Series, Ticks } from "../../api/types";
import { closeUp, ticksFor } from "./close_up";

const series: Series = {
  rate_hz: 1000,
  step_ticks: 300,
  t_s: [0, 0.3, 0.6],
  force_n: [1, 1, 1],
  force_mean_n: [1, 1, 1],
  computed_n: [1, 1, 1],
  late_ticks: [0, 0, 0],
  bound_n: [6, 6, 6],
  removed_mm3: [0, 3, 3],
  removed_by_tissue: {},
  anchor_mm: [
    [0, 0, 0],
    [0, 0, 0],
    [0, 0, 0],
  ],
  force_vector_n: [
    [0, 0, 1],
    [0, 0, 1],
    [0, 0, 1],
  ],
};

test("ticks are requested in blocks, and only for a short part", () => {
  assert.equal(ticksFor(series, undefined), undefined);
  assert.equal(ticksFor(series, [0, 10]), undefined);
  assert.deepEqual(ticksFor(series, [12.3, 14.9]), [12000, 16000]);
  assert.deepEqual(ticksFor(series, [12.5, 15.1]), [12000, 16000], "the same after a small move");
  assert.deepEqual(ticksFor(series, [12.9, 15.9]), [12000, 16000], "three seconds always fit");
  assert.equal(ticksFor(series, [12.9, 16.1]), undefined);
  assert.deepEqual(ticksFor({ ...series, rate_hz: 4000 }, [2, 2.5]), [8000, 12000]);
  assert.equal(ticksFor({ ...series, step_ticks: 1 }, [1, 2]), undefined, "each step is a tick already");
});

const ticks: Ticks = {
  from: 0,
  to: 4000,
  time_ticks: [149, 150, 450, 900],
  force_n: [1, 2, 3, 4],
  computed_n: [1, 2, 3.5, 4],
  late: [0, 0, 0, 0],
  limited: [0, 0, 1, 0],
};

test("a gap of the recording is a gap of the line", () => {
  const { timeS, forceN, computedN } = closeUp(ticks, series);
  assert.deepEqual(timeS, [0.149, 0.15, 0.151, 0.45, 0.451, 0.9]);
  assert.deepEqual(forceN, [1, 2, null, 3, null, 4]);
  assert.deepEqual(computedN, [1, 2, null, 3.5, null, 4]);
  assert.equal(closeUp({ ...ticks, limited: [0, 0, 0, 0] }, series).computedN, undefined);
});

test("what was removed goes straight from step to step", () => {
  const { removedMm3 } = closeUp(ticks, series);
  assert.ok(Math.abs(removedMm3[1]! - 1.5) < 1e-9);
  assert.equal(removedMm3[3], 3);
  assert.equal(removedMm3.at(-1), 3);
  assert.deepEqual(
    closeUp({ ...ticks, time_ticks: [], force_n: [], computed_n: [], late: [], limited: [] }, series).timeS,
    [],
  );
});
