import type { BlockMesh } from "./mesher";

// Triangles as other programs read them: STL, binary, little-endian. 80 bytes of anything, the number of triangles,
// and for each its normal and three corners (f32, mm) and two bytes of nothing.

const kHeadBytes = 84;
const kTriangleBytes = 50;
const kName = "Enamel, mm"; // must not begin with "solid", as a text does

export function stlOf(meshes: readonly Pick<BlockMesh, "positionMm" | "triangle">[]): ArrayBuffer {
  const count = meshes.reduce((sum, { triangle }) => sum + triangle.length / 3, 0);
  const bytes = new ArrayBuffer(kHeadBytes + count * kTriangleBytes);
  const view = new DataView(bytes);
  new TextEncoder().encodeInto(kName, new Uint8Array(bytes));
  view.setUint32(80, count, true);
  let at = kHeadBytes;
  for (const { positionMm: p, triangle } of meshes)
    for (let i = 0; i < triangle.length; i += 3) {
      const corners = [triangle[i]!, triangle[i + 1]!, triangle[i + 2]!];
      const numbers = corners.flatMap((corner) => [p[3 * corner]!, p[3 * corner + 1]!, p[3 * corner + 2]!]);
      for (const [k, value] of [...normalOf(numbers), ...numbers].entries()) view.setFloat32(at + 4 * k, value, true);
      at += kTriangleBytes;
    }
  return bytes;
}

// Of a triangle's nine numbers. Zero where it has no area.
function normalOf(n: readonly number[]): readonly number[] {
  const [ux, uy, uz] = [n[3]! - n[0]!, n[4]! - n[1]!, n[5]! - n[2]!];
  const [vx, vy, vz] = [n[6]! - n[0]!, n[7]! - n[1]!, n[8]! - n[2]!];
  const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
  const length = Math.hypot(x, y, z) || 1;
  return [x / length, y / length, z / length];
}
