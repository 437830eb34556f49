import type { Result } from "../base/result";
import type { BlockMesh } from "./mesher";
import { Broken, fromPlanes, type Grid, inflate, reading, sectionsOf, unzigzag } from "./packed";
import { kSteps } from "./samples";
import { kTissues } from "./tissue_color";

// Reads a mesh of a part of a tooth (schemas/surface_timeline.md, "Meshes").

const kMost = 1 << 22;
const kNextVertex = 0;
const kNewStrip = 1;

export function decodeMesh(bytes: Uint8Array<ArrayBuffer>, grid: Grid): Promise<Result<BlockMesh, string>> {
  return reading(async () => {
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
    const [n, m] = [view.getUint32(0, true), view.getUint32(4, true)];
    if (n > kMost || m > kMost) throw new Broken("a mesh has more vertices or strips than this page draws");
    const [positions, normals, tissues, strips] = sectionsOf(bytes, 8, 4, "a mesh");
    const tissue = await inflate(tissues!, n, "tissues");
    if (tissue.some((one) => one >= kTissues)) throw new Broken("a vertex is of no tissue");
    return {
      positionMm: positionsOf(await inflate(positions!, 12 * n, "positions"), n, grid),
      normal: normalsOf(await inflate(normals!, 2 * n, "normals"), n),
      tissue,
      deviation: undefined,
      triangle: trianglesOf(await inflate(strips!, 4 * m, "strips"), n, m),
    };
  });
}

function positionsOf(planes: Uint8Array, n: number, { voxelMm, originMm }: Grid): Float32Array<ArrayBuffer> {
  const out = new Float32Array(3 * n);
  for (let axis = 0; axis < 3; ++axis) {
    let steps = 0;
    for (let i = 0; i < n; ++i) {
      steps = (steps + unzigzag(fromPlanes(planes, 4 * n * axis, n, i))) | 0;
      out[3 * i + axis] = originMm[axis as 0 | 1 | 2] + (steps / kSteps - 1) * voxelMm;
    }
  }
  return out;
}

function normalsOf(columns: Uint8Array, n: number): Int8Array<ArrayBuffer> {
  const out = new Int8Array(4 * n);
  const uv = new Int8Array(2);
  for (let i = 0; i < n; ++i) {
    uv[0]! += columns[i]!;
    uv[1]! += columns[n + i]!;
    let [x, y] = [uv[0]! / 127, uv[1]! / 127];
    const z = 1 - Math.abs(x) - Math.abs(y);
    if (z < 0) [x, y] = [(1 - Math.abs(y)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (y < 0 ? -1 : 1)];
    const length = Math.sqrt(x * x + y * y + z * z) || 1;
    out[4 * i] = Math.round((127 * x) / length);
    out[4 * i + 1] = Math.round((127 * y) / length);
    out[4 * i + 2] = Math.round((127 * z) / length);
  }
  return out;
}

function trianglesOf(planes: Uint8Array, n: number, m: number): Uint32Array<ArrayBuffer> {
  const out = new Uint32Array(3 * m);
  let corners = 0;
  let next = 0;
  let place = 0; // in the strip
  let [before, last] = [0, 0];
  for (let i = 0; i < m; ++i) {
    const code = fromPlanes(planes, 0, m, i);
    if (code === kNewStrip) {
      place = 0;
      continue;
    }
    const vertex = code === kNextVertex ? next++ : next - code + 1;
    if (vertex < 0 || vertex >= n) throw new Broken("a strip names a vertex beyond the last");
    if (place >= 2 && before !== last && last !== vertex && vertex !== before) {
      const even = place % 2 === 0;
      out[corners++] = even ? before : last;
      out[corners++] = even ? last : before;
      out[corners++] = vertex;
    }
    before = last;
    last = vertex;
    ++place;
  }
  if (next !== n) throw new Broken("a vertex belongs to no strip");
  return out.slice(0, corners);
}
