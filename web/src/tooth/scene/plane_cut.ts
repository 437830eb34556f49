type Vec = readonly [number, number, number];
export type Plane = readonly [number, number, number, number]; // normal, and what is added: 0 on the plane

// Appends to `out` where the plane normal · p + constant = 0 cuts the triangles: six numbers for
// each, the two ends.
export function crossings(
  position: Float32Array,
  triangle: Uint32Array | Uint16Array,
  [nx, ny, nz]: Vec,
  constant: number,
  out: number[],
): void {
  const height = (vertex: number) =>
    nx * position[3 * vertex]! + ny * position[3 * vertex + 1]! + nz * position[3 * vertex + 2]! + constant;
  for (let i = 0; i < triangle.length; i += 3) {
    const [a, b, c] = [triangle[i]!, triangle[i + 1]!, triangle[i + 2]!];
    const [ha, hb, hc] = [height(a), height(b), height(c)];
    // A corner on the plane counts as above it: each triangle is then cut in two edges or none.
    const [above, beside, opposite] = [ha >= 0, hb >= 0, hc >= 0];
    if (above === beside && beside === opposite) continue;
    if (above !== beside) along(position, a, ha, b, hb, out);
    if (beside !== opposite) along(position, b, hb, c, hc, out);
    if (opposite !== above) along(position, c, hc, a, ha, out);
  }
}

function along(p: Float32Array, a: number, ha: number, b: number, hb: number, out: number[]): void {
  const share = ha / (ha - hb);
  for (let axis = 0; axis < 3; ++axis) out.push(p[3 * a + axis]! + share * (p[3 * b + axis]! - p[3 * a + axis]!));
}
