import type { BlockMesh } from "../mesher";

// Fissures are dark and what a bur cut is matt, as at the chair (station/render/tooth_looks.cpp), as far as a mesh tells.

const kEnamel = 1;
// Curvature across a groove from which on it is stained, and where that is full; 1/mm.
export const kFrom = 0.9;
export const kFull = 3.2;
export const kMaxStained = 0.65; // of the colour
export const kStainSteps = 15;
export const kCutFlag = 128;

// Of each vertex: its tissue, 8 × its stain, and kCutFlag. The surface's curvature is how its normals turn along the
// edges of its triangles; in a groove they lean toward each other.
export function withStain({ positionMm: p, normal, tissue, triangle, cut }: BlockMesh): Uint8Array<ArrayBuffer> {
  const bent = new Float32Array(tissue.length);
  const grown = tissue.map((own, i) => (own === kEnamel && !cut?.[i] ? 1 : 0));
  for (let t = 0; t < triangle.length; t += 3) {
    // Most of a moment's triangles are of what was cut.
    if ((grown[triangle[t]!]! | grown[triangle[t + 1]!]! | grown[triangle[t + 2]!]!) === 0) continue;
    for (let side = 0; side < 3; ++side) {
      const a = triangle[t + side]!;
      const b = triangle[side === 2 ? t : t + side + 1]!;
      const x = p[3 * b]! - p[3 * a]!;
      const y = p[3 * b + 1]! - p[3 * a + 1]!;
      const z = p[3 * b + 2]! - p[3 * a + 2]!;
      const turn =
        x * (normal[4 * a]! - normal[4 * b]!) +
        y * (normal[4 * a + 1]! - normal[4 * b + 1]!) +
        z * (normal[4 * a + 2]! - normal[4 * b + 2]!);
      const found = turn / (127 * (x * x + y * y + z * z));
      if (found > bent[a]!) bent[a] = found;
      if (found > bent[b]!) bent[b] = found;
    }
  }
  return tissue.map((own, i) => {
    if (cut?.[i]) return own + kCutFlag;
    const share = own === kEnamel ? Math.min(1, Math.max(0, (bent[i]! - kFrom) / (kFull - kFrom))) : 0;
    return own + 8 * Math.round(kStainSteps * share * share * (3 - 2 * share));
  });
}
