import assert from "node:assert/strict";
import { test } from "node:test";
import type { Series } from "../../api/types";
import { rangeRows, rangeTable, removedIn } from "./range";
import { speeds } from "./speed";

const series = {
  rate_hz: 1000,
  step_ticks: 500,
  t_s: [0, 0.5, 1, 1.5],
  force_n: [1, 3, 2, 4],
  force_mean_n: [1, 1, 1, 1],
  bound_n: [0, 8, 8, 8],
  removed_mm3: [1, 3, 6, 10],
  removed_by_tissue: { enamel: [1, 3, 4, 4], dentin: [0, 0, 2, 6] },
  anchor_mm: [
    [0, 0, 0],
    [3, 4, 0],
    [3, 4, 0],
    [3, 4, -2],
  ],
} as unknown as Series;

test("mean, peak, root mean square and 95th percentile are of the steps of the range", () => {
  const [largest, mean] = rangeRows(series, speeds(series), 1, 3);
  assert.deepEqual([largest!.mean, largest!.peak, largest!.p95], [3, 4, 4]);
  assert.ok(Math.abs(largest!.rms - Math.sqrt((9 + 4 + 16) / 3)) < 1e-12);
  assert.deepEqual([mean!.mean, mean!.peak, mean!.rms, mean!.p95], [1, 1, 1, 1]);
  const twenty = { ...series, force_n: Array.from({ length: 20 }, (_, i) => i + 1) } as unknown as Series;
  assert.equal(rangeRows(twenty, speeds(twenty), 0, 19)[0]!.p95, 19);
});

test("speed is the path of a step divided by its time, and removal is listed by tissue", () => {
  assert.deepEqual(speeds(series), [0, 10, 0, 4]);
  assert.deepEqual(removedIn(series, 0, 3), [
    ["all", 10],
    ["enamel", 4],
    ["dentin", 6],
  ]);
  assert.deepEqual(removedIn(series, 2, 3), [
    ["all", 7],
    ["enamel", 1],
    ["dentin", 6],
  ]);
});

test("the file has a line for each step of the range, with units in its titles", () => {
  const { header, rows } = rangeTable(series, speeds(series), 1, 2);
  assert.equal(header.length, rows[0]!.length);
  assert.deepEqual(
    rows.map((row) => row[0]),
    [0.5, 1],
  );
  assert.deepEqual(header.slice(5, 8), ["removed_mm3", "removed_enamel_mm3", "removed_dentin_mm3"]);
  assert.equal(rangeTable(series, speeds(series), 0, 99).rows.length, 4);
});
