import assert from "node:assert/strict";
import { test } from "node:test";
import { panned, showing, type View, zoomed } from "./view";

const whole: View = [0, 100];

test("what is under the pointer stays there, and nothing outside the attempt is shown", () => {
  assert.deepEqual(zoomed(whole, undefined, 50, 0.5), [25, 75]);
  assert.deepEqual(zoomed(whole, [25, 75], 30, 0.5), [27.5, 52.5]);
  assert.deepEqual(zoomed(whole, [0, 50], 0, 1.5), [0, 75]);
  assert.deepEqual(zoomed(whole, [60, 100], 60, 1.5), [40, 100]);
  assert.equal(zoomed(whole, [25, 75], 50, 4), undefined, "all of it");
  const [from, to] = zoomed(whole, [50, 50.6], 50.3, 0.1)!;
  assert.ok(Math.abs(to - from - 0.1) < 1e-9, "no shorter than a tenth of a second");
});

test("a part is moved within the attempt, and follows the moment when that leaves it", () => {
  assert.deepEqual(panned(whole, [20, 40], 10), [30, 50]);
  assert.deepEqual(panned(whole, [20, 40], -50), [0, 20]);
  assert.equal(panned(whole, undefined, 10), undefined);
  assert.deepEqual(showing(whole, [20, 40], 30), [20, 40]);
  assert.deepEqual(showing(whole, [20, 40], 70), [60, 80]);
  assert.deepEqual(showing(whole, [20, 40], 100), [80, 100]);
});
