import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeSurface } from "./surface";

// Three vertices: the padding of positions and of tissues is not zero bytes long.
function encode({ deviation = true, version = 1, vertices = 3, triangle = [0, 1, 2] } = {}): ArrayBuffer {
  const n = 3;
  const bytes: number[] = [];
  const put = (size: number, write: (view: DataView) => void) => {
    const view = new DataView(new ArrayBuffer(size));
    write(view);
    bytes.push(...new Uint8Array(view.buffer));
  };
  const u16 = (value: number) => put(2, (view) => view.setUint16(0, value, true));
  const u32 = (value: number) => put(4, (view) => view.setUint32(0, value, true));
  const f32 = (value: number) => put(4, (view) => view.setFloat32(0, value, true));
  const pad = () => {
    while (bytes.length % 4 !== 0) bytes.push(0);
  };
  bytes.push(...[..."ENTM"].map((letter) => letter.charCodeAt(0)));
  u16(version);
  u16(deviation ? 1 : 0);
  u32(vertices);
  u32(1);
  for (const value of [-5, -4, -3]) f32(value);
  f32(0.25);
  for (let i = 0; i < 3 * n; ++i) u16(i * 10);
  pad();
  for (let i = 0; i < n; ++i) bytes.push(0, 0, 127, 0);
  bytes.push(1, 2, 3);
  pad();
  if (deviation) for (const value of [0.3, Number.NaN, -0.1]) f32(value);
  for (const index of triangle) u32(index);
  return new Uint8Array(bytes).buffer;
}

const error = (bytes: ArrayBuffer) => {
  const result = decodeSurface(bytes);
  assert.equal(result.ok, false);
  return result.ok ? "" : result.error;
};

test("positions are origin plus scale times the stored integers", () => {
  const result = decodeSurface(encode());
  assert.ok(result.ok);
  assert.deepEqual([...result.value.positionMm], [-5, -1.5, 2, 2.5, 6, 9.5, 10, 13.5, 17]);
});

test("tissues, normals, deviation with NaN, and triangles are read from behind the padding", () => {
  const result = decodeSurface(encode());
  assert.ok(result.ok);
  assert.deepEqual([...result.value.tissue], [1, 2, 3]);
  assert.deepEqual([...result.value.normal.slice(0, 4)], [0, 0, 127, 0]);
  assert.deepEqual(
    [...result.value.deviationMm!].map((value) => Math.round(value * 1000) / 1000),
    [0.3, Number.NaN, -0.1],
  );
  assert.deepEqual([...result.value.triangle], [0, 1, 2]);
});

test("a surface without the deviation flag has no deviation", () => {
  const result = decodeSurface(encode({ deviation: false }));
  assert.ok(result.ok);
  assert.equal(result.value.deviationMm, undefined);
});

test("a surface cut off at any byte is refused", () => {
  const whole = encode();
  for (let length = 0; length < whole.byteLength; ++length) error(whole.slice(0, length));
});

test("bytes after the end are refused", () => {
  const longer = new Uint8Array(encode().byteLength + 4);
  longer.set(new Uint8Array(encode()));
  assert.match(error(longer.buffer), /has 92 bytes, found 96/);
});

test("another magic, another version and absurd counts are refused with what was found", () => {
  const other = encode();
  new DataView(other).setUint8(0, 0x58);
  assert.match(error(other), /begins with ENTM/);
  assert.match(error(encode({ version: 2 })), /reads surface version 1, found version 2/);
  assert.match(error(encode({ vertices: 0xffffffff })), /larger than this page draws/);
});

test("a triangle that names a vertex beyond the last is refused", () => {
  assert.match(error(encode({ triangle: [0, 1, 3] })), /beyond the 3 there are/);
});
