import type { Compared, Extent } from "./messages";
import type { BlockMesh } from "./mesher";

// Of a mesh, these vertices where they were compared.
export function comparedIn({ positionMm, normal, deviation }: BlockMesh, vertices: readonly number[]): Compared {
  const own = vertices.filter((vertex) => deviation?.[2 * vertex + 1] === 1);
  const out = {
    positionMm: new Float32Array(3 * own.length),
    normal: new Int8Array(4 * own.length),
    deviationMm: new Float32Array(own.length),
  };
  own.forEach((vertex, i) => {
    for (let axis = 0; axis < 3; ++axis) {
      out.positionMm[3 * i + axis] = positionMm[3 * vertex + axis]!;
      out.normal[4 * i + axis] = normal[4 * vertex + axis]!;
    }
    out.deviationMm[i] = deviation![2 * vertex]!;
  });
  return out;
}

export function joined(parts: readonly Compared[]): Compared {
  const count = parts.reduce((sum, part) => sum + part.deviationMm.length, 0);
  const out = {
    positionMm: new Float32Array(3 * count),
    normal: new Int8Array(4 * count),
    deviationMm: new Float32Array(count),
  };
  let at = 0;
  for (const part of parts) {
    out.positionMm.set(part.positionMm, 3 * at);
    out.normal.set(part.normal, 4 * at);
    out.deviationMm.set(part.deviationMm, at);
    at += part.deviationMm.length;
  }
  return out;
}

// The ball around the middle of the box around all of these places. Undefined: there are none.
export function boxBall(places: readonly Float32Array[]): Extent | undefined {
  const low: [number, number, number] = [Infinity, Infinity, Infinity];
  const high: [number, number, number] = [-Infinity, -Infinity, -Infinity];
  for (const one of places)
    for (let i = 0; i < one.length; ++i) {
      const value = one[i]!;
      if (value < low[i % 3]!) low[i % 3] = value;
      if (value > high[i % 3]!) high[i % 3] = value;
    }
  if (low[0] === Infinity) return undefined;
  const centreMm = [0, 1, 2].map((axis) => (low[axis]! + high[axis]!) / 2) as [number, number, number];
  let most = 0;
  for (const one of places)
    for (let i = 0; i < one.length; i += 3)
      most = Math.max(
        most,
        (one[i]! - centreMm[0]) ** 2 + (one[i + 1]! - centreMm[1]) ** 2 + (one[i + 2]! - centreMm[2]) ** 2,
      );
  return { centreMm, radiusMm: Math.sqrt(most) };
}
