import assert from "node:assert/strict";
import { test } from "node:test";
import { stlOf } from "./stl";

test("an STL has each triangle with its normal and corners, in millimetres", () => {
  const one = { positionMm: Float32Array.of(0, 0, 1, 2, 0, 1, 0, 3, 1), triangle: Uint16Array.of(0, 1, 2) };
  const other = { positionMm: Float32Array.of(5, 0, 0, 5, 1, 0, 5, 0, 1), triangle: Uint32Array.of(0, 1, 2, 0, 0, 0) };
  const view = new DataView(stlOf([one, other]));
  assert.equal(view.byteLength, 84 + 3 * 50);
  assert.equal(view.getUint32(80, true), 3);
  const numbers = (triangle: number) =>
    Array.from({ length: 12 }, (_, i) => view.getFloat32(84 + 50 * triangle + 4 * i, true));
  assert.deepEqual(numbers(0), [0, 0, 1, 0, 0, 1, 2, 0, 1, 0, 3, 1]);
  assert.deepEqual(numbers(1).slice(0, 3), [1, 0, 0]);
  assert.deepEqual(numbers(2).slice(0, 3), [0, 0, 0], "a triangle without an area has no direction");
  assert.notEqual(String.fromCharCode(...new Uint8Array(view.buffer, 0, 5)), "solid", "which begins a text");
});
