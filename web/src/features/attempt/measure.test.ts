import assert from "node:assert/strict";
import { test } from "node:test";
import { angleDeg, distanceMm, joinedLines, measuredText, withPoint } from "./measure";
import { deepestOf } from "./profile";

test("distance and angle are those of a right triangle", () => {
  assert.equal(distanceMm([1, 1, 1], [1, 4, 5]), 5);
  assert.ok(Math.abs(angleDeg([3, 0, 0], [0, 0, 0], [0, 0, 4])! - 90) < 1e-9);
  assert.ok(Math.abs(angleDeg([1, 0, 0], [0, 0, 0], [1, 1, 0])! - 45) < 1e-9);
  assert.equal(angleDeg([1, 0, 0], [-2, 0, 0], [1, 0, 0]), 0);
  assert.equal(angleDeg([1, 2, 3], [1, 2, 3], [0, 0, 0]), undefined, "at a point that is two of them");
});

test("a fourth point begins anew", () => {
  let points = withPoint([], [0, 0, 0]);
  points = withPoint(withPoint(points, [1, 0, 0]), [1, 1, 0]);
  assert.equal(points.length, 3);
  assert.deepEqual(withPoint(points, [5, 5, 5]), [[5, 5, 5]]);
});

test("what is measured is said with its unit, and what comes next", () => {
  assert.match(measuredText([]), /first point/);
  assert.match(
    measuredText([
      [0, 0, 0],
      [0, 0, 1.234],
    ]),
    /1\.23\u00a0mm/,
  );
  assert.match(
    measuredText([
      [1, 0, 0],
      [0, 0, 0],
      [0, 2, 0],
    ]),
    /1\.00\u00a0mm.*2\.00\u00a0mm.*90\.0°/,
  );
});

test("the target's lines and the measured ones are drawn together", () => {
  const solid = [[[0, 0, 0]] as const];
  assert.equal(joinedLines(undefined, undefined), undefined);
  assert.deepEqual(joinedLines({ solid, faint: [] }, { solid: [], faint: solid }), { solid, faint: solid });
});

test("the deepest place of a profile, where there is a surface", () => {
  assert.deepEqual(deepestOf(Float32Array.of(0, -0.5, Number.NaN, -0.25, 0), 4), { depthMm: 0.5, atMm: 1 });
  assert.deepEqual(deepestOf(Float32Array.of(0.5, 1, 0.5), 2), { depthMm: -0.5, atMm: 0 });
  assert.equal(deepestOf(Float32Array.of(Number.NaN, Number.NaN), 2), undefined);
});
