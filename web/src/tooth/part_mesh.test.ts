import assert from "node:assert/strict";
import { test } from "node:test";
import { goldenHead, goldenPart, value } from "./golden.test";
import { decodeMesh } from "./part_mesh";

test("the golden meshes are what the document says", async () => {
  const { grid } = await goldenHead();
  const still = value(await decodeMesh(await goldenPart("still"), grid));
  const middle = -1.95 + 0.1 * 19.5;
  const away = (0.1 * 915) / 64;
  const near = (found: ArrayLike<number>, expected: readonly number[]) => {
    assert.equal(found.length, expected.length);
    expected.forEach((mm, i) => {
      assert.ok(Math.abs(found[i]! - mm) < 1e-5, `${i}: ${found[i]} and ${mm}`);
    });
  };
  near(still.positionMm, [
    ...[middle + away, middle, middle],
    ...[middle, middle + away, middle],
    ...[middle, middle - away, middle],
    ...[middle - away, middle, middle],
    ...[middle, middle, middle - away],
  ]);
  assert.deepEqual(
    [...still.normal],
    [127, 0, 0, 0, 0, 127, 0, 0, 0, -127, 0, 0, -127, 0, 0, 0, 0, 0, -127, 0].map((n) => n + 0),
  );
  assert.deepEqual([...still.tissue], [1, 1, 1, 1, 1]);
  assert.deepEqual([...still.triangle], [0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 1, 4, 1, 0, 0, 2, 4]);
  const end = value(await decodeMesh(await goldenPart("end"), grid));
  const half = (0.1 * 457) / 64;
  near(end.positionMm, [
    ...[middle + half, middle, middle + half],
    ...[middle, middle + half, middle + half],
    ...[middle - half, middle - half, middle + half],
  ]);
  assert.deepEqual([...end.tissue], [1, 1, 2]);
  assert.deepEqual([...end.triangle], [0, 1, 2]);
});

test("damaged meshes are refused, and none reads beyond its vertices", async () => {
  const { grid } = await goldenHead();
  const bytes = await goldenPart("still");
  for (let end = 0; end < bytes.length; ++end)
    assert.equal((await decodeMesh(bytes.slice(0, end), grid)).ok, false, `${end} bytes`);
  for (let at = 0; at < bytes.length; ++at) {
    const bad = bytes.slice();
    bad[at]! ^= 0xff;
    const mesh = await decodeMesh(bad, grid);
    if (mesh.ok) assert.ok(mesh.value.triangle.every((corner) => corner < mesh.value.tissue.length));
  }
});
