import { type Gl, Shape } from "./gl";

// Solids that a scene shows beside its tooth.

const kAround = 32; // pieces of a turn

// A body of revolution around +z: places along it and radii, from one end to the other. It is closed at both ends,
// also where the outline ends at a radius. Its light is smooth, as on worn steel.
export function revolved(gl: Gl, outline: readonly (readonly [number, number])[]): Shape {
  const closed = [[outline[0]![0], 0] as const, ...outline, [outline.at(-1)![0], 0] as const];
  // Outwards from each piece of the outline: along the axis, and away from it.
  const pieces = closed.slice(1).map(([to, far], i) => {
    const [from, near] = closed[i]!;
    const length = Math.hypot(to - from, far - near) || 1;
    return [(near - far) / length, (to - from) / length] as const;
  });
  const position: number[] = [];
  const normal: number[] = [];
  for (const [i, [place, radius]] of closed.entries()) {
    const [before, after] = [pieces[i - 1] ?? pieces[i]!, pieces[i] ?? pieces[i - 1]!];
    const [along, away] = [before[0] + after[0], before[1] + after[1]];
    const length = Math.hypot(along, away) || 1;
    for (let k = 0; k < kAround; ++k) {
      const angle = (2 * Math.PI * k) / kAround;
      const [x, y] = [Math.cos(angle), Math.sin(angle)];
      position.push(radius * x, radius * y, place);
      normal.push(...[away * x, away * y, along].map((part) => Math.round((127 * part) / length)), 0);
    }
  }
  const index: number[] = [];
  for (let i = 1; i < closed.length; ++i)
    for (let k = 0; k < kAround; ++k) {
      const next = (k + 1) % kAround;
      const [a, b, c, d] = [(i - 1) * kAround + k, (i - 1) * kAround + next, i * kAround + next, i * kAround + k];
      index.push(a, b, c, a, c, d);
    }
  return new Shape(
    gl,
    {
      position: { data: Float32Array.from(position), size: 3 },
      normal: { data: Int8Array.from(normal), size: 4, normalized: true },
    },
    Uint16Array.from(index),
  );
}

// Around the origin, of the radius 1.
export function ball(gl: Gl): Shape {
  const kPieces = 16; // from pole to pole
  return revolved(
    gl,
    Array.from({ length: kPieces + 1 }, (_, i) => {
      const angle = (Math.PI * i) / kPieces;
      return [-Math.cos(angle), Math.sin(angle)] as const;
    }),
  );
}
