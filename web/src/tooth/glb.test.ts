import assert from "node:assert/strict";
import { test } from "node:test";
import { glbOf } from "./glb";

const kOne = {
  positionMm: Float32Array.of(0, 0, 1, 2, 0, 1, 0, 3, 1),
  normal: Int8Array.of(0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 100, 0),
  tissue: Uint8Array.of(1, 1, 2),
  triangle: Uint16Array.of(0, 1, 2),
};

function read(bytes: ArrayBuffer) {
  const view = new DataView(bytes);
  const words = Array.from({ length: 5 }, (_, i) => view.getUint32(4 * i, true));
  const size = words[3]!;
  const json = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 20, size)));
  return { words, json, bin: 28 + size, view };
}

test("a GLB says its length, has two chunks, and every part begins where four divides", () => {
  const bytes = glbOf([kOne, kOne]);
  const { words, json, bin, view } = read(bytes);
  assert.deepEqual(words.slice(0, 3), [0x46546c67, 2, bytes.byteLength]);
  assert.equal(words[3]! % 4, 0);
  assert.equal(view.getUint32(bin - 8, true), json.buffers[0].byteLength);
  assert.equal(bytes.byteLength, bin + json.buffers[0].byteLength);
  for (const { byteOffset } of json.bufferViews) assert.equal(byteOffset % 4, 0);
});

test("the meshes are joined, with bounds, unit normals and the colours of their tissues", () => {
  const { json, bin, view } = read(glbOf([kOne, kOne]));
  const [position, normal, color, index] = json.accessors;
  assert.deepEqual([position.count, normal.count, color.count, index.count], [6, 6, 6, 6]);
  assert.deepEqual(
    [position.min, position.max],
    [
      [0, 0, 1],
      [2, 3, 1],
    ],
  );
  const of = (part: number) => bin + json.bufferViews[part].byteOffset;
  assert.deepEqual(
    Array.from({ length: 6 }, (_, i) => view.getUint32(of(3) + 4 * i, true)),
    [0, 1, 2, 3, 4, 5],
  );
  assert.equal(view.getFloat32(of(1) + 8, true), 1);
  assert.equal(view.getFloat32(of(1) + 4 * 8, true), 1, "a short normal is made a unit");
  assert.notEqual(view.getUint32(of(2), true), view.getUint32(of(2) + 8, true), "enamel and dentin differ");
});

test("a tooth without triangles is a file too", () => {
  const { json } = read(glbOf([]));
  assert.equal(json.accessors[0].count, 0);
});
