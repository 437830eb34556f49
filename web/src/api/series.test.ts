import assert from "node:assert/strict";
import { test } from "node:test";
import { checkSeries } from "./series";

const series = (changes: object = {}) => ({
  rate_hz: 1000,
  step_ticks: 20,
  t_s: [0, 0.02],
  force_n: [0.1, 0.2],
  force_mean_n: [0.1, 0.1],
  computed_n: [0.1, 0.2],
  late_ticks: [0, 0],
  bound_n: [3, 3],
  removed_mm3: [0, 0.1],
  removed_by_tissue: { enamel: [0, 0.1] },
  anchor_mm: [
    [0, 0, 0],
    [0, 0, 1],
  ],
  force_vector_n: [
    [0, 0, 0.1],
    [0, 0, 0.2],
  ],
  ...changes,
});

test("columns of one length with finite numbers are a series", () => {
  assert.equal(checkSeries(series()).ok, true);
  assert.equal(
    checkSeries(
      series({
        t_s: [],
        force_n: [],
        force_mean_n: [],
        computed_n: [],
        late_ticks: [],
        bound_n: [],
        removed_mm3: [],
        removed_by_tissue: {},
        anchor_mm: [],
        force_vector_n: [],
      }),
    ).ok,
    true,
  );
});

test("a missing, short or not numeric column is refused by name", () => {
  for (const changes of [{ force_n: [1] }, { force_n: undefined }, { force_n: [1, null] }, { force_n: [1, "2"] }]) {
    const result = checkSeries(series(changes));
    assert.match(result.ok ? "" : result.error, /force_n/);
  }
  assert.equal(
    checkSeries(
      series({
        anchor_mm: [
          [0, 0],
          [0, 0, 1],
        ],
      }),
    ).ok,
    false,
  );
  assert.equal(checkSeries(series({ removed_by_tissue: { enamel: [1] } })).ok, false);
  assert.equal(checkSeries(null).ok, false);
});

test("the error of the force in a hand is a number where it is given", () => {
  assert.equal(checkSeries(series({ felt_error: 0.36 })).ok, true);
  assert.equal(checkSeries(series({ felt_error: "0.36" })).ok, false);
});

test("time that stands still or runs back is refused", () => {
  assert.equal(checkSeries(series({ t_s: [0.02, 0.02] })).ok, false);
});
