import assert from "node:assert/strict";
import { test } from "node:test";
import { PerspectiveCamera, Vector3 } from "three";
import { pxPerMm } from "./overlay";

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
