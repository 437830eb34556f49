import assert from "node:assert/strict";
import { test } from "node:test";
import { PerspectiveCamera, Vector3 } from "three";
import type { Anatomy } from "../../api/tooth_number";
import type { PointMm } from "../../tooth/messages";
import { axisEnds, clearOf, pxPerMm } from "./overlay";

test("the scale is what a camera makes of a millimetre across the picture, also aside of its middle", () => {
  const camera = new PerspectiveCamera(28, 1.5, 0.1, 500);
  camera.position.set(5, -20, 30);
  camera.lookAt(1, 2, 3);
  camera.updateMatrixWorld();
  const matrix = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).toArray();
  const right = new Vector3(1, 0, 0).transformDirection(camera.matrixWorld);
  for (const at of [new Vector3(1, 2, 3), new Vector3(4, 2, 3)]) {
    const step = 1e-4;
    const moved = at.clone().addScaledVector(right, step);
    const across = moved.project(camera).x - at.clone().project(camera).x;
    const expected = ((across / step) * 600) / 2;
    const found = pxPerMm(matrix, [at.x, at.y, at.z], 600);
    // Aside of the middle a point may also come nearer while it goes across.
    assert.ok(Math.abs(found / expected - 1) < (at.x === 1 ? 1e-3 : 0.05), `${found} and ${expected}`);
  }
});

test("the axes in the corner point as the tooth lies", () => {
  // Straight from above: to the right is +x, up is +y.
  const fromAbove = ([x, y, z]: PointMm): PointMm => [100 + 10 * x, 100 - 10 * y, z];
  const ends = (anatomy: Anatomy) => axisEnds(anatomy, fromAbove, [0, 0, 0]).map((end) => end.map((part) => part + 0));
  assert.deepEqual(ends({ mesial: -1, up: "occlusal" }), [
    [-1, 0],
    [0, -1],
    [0, 0],
  ]);
});

test("the name of a side moves off the buttons that would hide it, towards the middle", () => {
  const views = { left: 8, right: 66, top: 8, bottom: 200 };
  const choices = { left: 360, right: 510, top: 8, bottom: 200 };
  const clear = (left: number, top: number) => clearOf([views, choices], left, top, 518);
  assert.equal(clear(40, 120), 66 + 38);
  assert.equal(clear(500, 120), 360 - 38);
  assert.equal(clear(40, 300), 40, "below them");
  assert.equal(clear(250, 120), 250, "between them");
});

test("it moves off a name in the middle to the nearer side", () => {
  const name = { left: 134, right: 213, top: 8, bottom: 30 };
  const clear = (left: number) => clearOf([name], left, 18, 346);
  assert.equal(clear(230), 213 + 38);
  assert.equal(clear(150), 134 - 38);
});
