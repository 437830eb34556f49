import type { Result } from "../base/result";

// A tooth surface as the server sends it: "ENTM" version 1, described in schemas/api/openapi.yaml
// at /attempts/{id}/surface. Loaded with the first one that is read (read_surface.ts), so it
// imports nothing that others have.
export interface Surface {
  readonly positionMm: Float32Array; // (n x 3), scene frame: +y buccal, +z occlusal, mesial as tooth_number.ts says
  readonly normal: Int8Array; // (n x 4), x y z 0, /127, outward
  readonly tissue: Uint8Array; // (n)
  readonly deviationMm: Float32Array | undefined; // (n), + = more removed than the reference, NaN = untouched
  readonly triangle: Uint32Array; // (m x 3), counter-clockwise seen from outside
}

const kMagic = 0x4d544e45; // "ENTM" read as a little-endian u32
const kVersion = 1;
const kHasDeviation = 1;
const kHeaderBytes = 32;
const kMaxVertices = 4_000_000; // a tooth at 25 um is near 2 million
const kMaxTriangles = 8_000_000;

const fail = (error: string) => ({ ok: false, error }) as const;

// The error says what was expected and found. Reads nothing beyond `bytes` whatever the header
// claims.
export function decodeSurface(bytes: ArrayBuffer): Result<Surface, string> {
  if (bytes.byteLength < kHeaderBytes)
    return fail(`a surface has at least ${kHeaderBytes} bytes, found ${bytes.byteLength}`);
  const view = new DataView(bytes);
  if (view.getUint32(0, true) !== kMagic) return fail("a surface begins with ENTM, found something else");
  const version = view.getUint16(4, true);
  if (version !== kVersion) return fail(`this page reads surface version ${kVersion}, found version ${version}`);
  const hasDeviation = (view.getUint16(6, true) & kHasDeviation) !== 0;
  const n = view.getUint32(8, true);
  const m = view.getUint32(12, true);
  if (n > kMaxVertices || m > kMaxTriangles)
    return fail(`the surface is larger than this page draws (${n} vertices, ${m} triangles)`);

  const normalAt = align4(kHeaderBytes + 6 * n);
  const tissueAt = normalAt + 4 * n;
  const deviationAt = align4(tissueAt + n);
  const triangleAt = deviationAt + (hasDeviation ? 4 * n : 0);
  const end = triangleAt + 12 * m;
  if (bytes.byteLength !== end)
    return fail(`a surface of ${n} vertices and ${m} triangles has ${end} bytes, found ${bytes.byteLength}`);

  const triangle = readUint32(view, triangleAt, 3 * m);
  if (triangle.some((index) => index >= n)) return fail(`a triangle names a vertex beyond the ${n} there are`);
  return {
    ok: true,
    value: {
      positionMm: readPositions(view, n),
      normal: new Int8Array(bytes, normalAt, 4 * n),
      tissue: new Uint8Array(bytes, tissueAt, n),
      deviationMm: hasDeviation ? readFloat32(view, deviationAt, n) : undefined,
      triangle,
    },
  };
}

function align4(offset: number): number {
  return (offset + 3) & ~3;
}

function readPositions(view: DataView, n: number): Float32Array {
  const origin = [view.getFloat32(16, true), view.getFloat32(20, true), view.getFloat32(24, true)];
  const scale = view.getFloat32(28, true);
  const position = new Float32Array(3 * n);
  for (let i = 0; i < 3 * n; ++i) position[i] = origin[i % 3]! + scale * view.getUint16(kHeaderBytes + 2 * i, true);
  return position;
}

function readFloat32(view: DataView, at: number, count: number): Float32Array {
  const values = new Float32Array(count);
  for (let i = 0; i < count; ++i) values[i] = view.getFloat32(at + 4 * i, true);
  return values;
}

function readUint32(view: DataView, at: number, count: number): Uint32Array {
  const values = new Uint32Array(count);
  for (let i = 0; i < count; ++i) values[i] = view.getUint32(at + 4 * i, true);
  return values;
}
