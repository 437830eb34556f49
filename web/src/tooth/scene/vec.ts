import { add, cross, dot, scaled, sub, type Vec } from "../../base/vec";

// Turns and matrices of a scene. Nothing changes what it is given.

export { add, cross, dot, scaled, sub, type Vec };
export type Quat = readonly [number, number, number, number]; // x y z, then the real part; of length 1
export type Matrix = readonly number[]; // 4 × 4, column by column

const kOpposite = 1e-12; // 1 + cosine: less has no axis of its own

export const lengthOf = (a: Vec): number => Math.hypot(...a);
// Nothing stays nothing.
export const withLength = (a: Vec, length: number): Vec => scaled(a, length / (lengthOf(a) || 1));
export const unit = (a: Vec): Vec => withLength(a, 1);

// The shortest turn from one direction to the other; both of length 1.
export function turnBetween(from: Vec, to: Vec): Quat {
  const real = 1 + dot(from, to);
  const [x, y, z] =
    real > kOpposite
      ? cross(from, to)
      : Math.abs(from[0]) > Math.abs(from[2])
        ? [-from[1], from[0], 0]
        : [0, -from[2], from[1]];
  const w = real > kOpposite ? real : 0;
  const length = Math.hypot(x, y, z, w);
  return [x / length, y / length, z / length, w / length];
}

export const inverse = ([x, y, z, w]: Quat): Quat => [-x, -y, -z, w];

export function turned([x, y, z, w]: Quat, v: Vec): Vec {
  const t = scaled(cross([x, y, z], v), 2);
  return add(add(v, scaled(t, w)), cross([x, y, z], t));
}

// Draws out along the axes, then turns, then moves.
export function placed(turn: Quat, at: Vec, scale: Vec = [1, 1, 1]): Matrix {
  const x = turned(turn, [scale[0], 0, 0]);
  const y = turned(turn, [0, scale[1], 0]);
  const z = turned(turn, [0, 0, scale[2]]);
  return [...x, 0, ...y, 0, ...z, 0, ...at, 1];
}
export const kUnturned: Quat = [0, 0, 0, 1];
export const kUnmoved: Matrix = placed(kUnturned, [0, 0, 0]);

export function product(a: Matrix, b: Matrix): Matrix {
  return Array.from({ length: 16 }, (_, i) => {
    const [row, column] = [i % 4, i - (i % 4)];
    return (
      a[row]! * b[column]! + a[row + 4]! * b[column + 1]! + a[row + 8]! * b[column + 2]! + a[row + 12]! * b[column + 3]!
    );
  });
}

// From the scene to a camera at `eye`, which looks along its −z at `target`; `up` is up in its picture.
export function viewFrom(eye: Vec, target: Vec, up: Vec): Matrix {
  let z = unit(sub(eye, target));
  // From straight above nothing is up: as from a little beside.
  if (lengthOf(cross(up, z)) === 0) z = unit(add(z, Math.abs(up[2]) === 1 ? [1e-4, 0, 0] : [0, 0, 1e-4]));
  const x = unit(cross(up, z));
  const y = cross(z, x);
  return [
    ...[x[0], y[0], z[0], 0],
    ...[x[1], y[1], z[1], 0],
    ...[x[2], y[2], z[2], 0],
    ...[-dot(x, eye), -dot(y, eye), -dot(z, eye), 1],
  ];
}

// From a camera to −1 … 1. `high`: tangent of half the angle from the picture's lower to its upper edge.
export function perspective(high: number, aspect: number, near: number, far: number): Matrix {
  return [
    ...[1 / (high * aspect), 0, 0, 0],
    ...[0, 1 / high, 0, 0],
    ...[0, 0, (far + near) / (near - far), -1],
    ...[0, 0, (2 * far * near) / (near - far), 0],
  ];
}
