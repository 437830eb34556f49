import type { Exercise } from "./types";

// Where mesial is in a scene's frame: 1, along +x, or -1, along -x. By the quadrant of the tooth's FDI
// number; a practice block, which is no tooth (null), has it at +x.
export type MesialX = 1 | -1;

export function mesialX(tooth: number | null): MesialX {
  return tooth !== null && Math.floor(tooth / 10) % 2 === 0 ? -1 : 1;
}

// How a tooth is turned in its scene's frame. `up` is the side that +z points out of.
export interface Anatomy {
  readonly mesial: MesialX;
  readonly up: "occlusal" | "buccal";
  readonly turn?: readonly [Vector, Vector, Vector]; // of a tooth that is being turned: this frame's axes in the scene
}

type Vector = readonly [number, number, number];

export function anatomyOf({ tooth, up }: Exercise["target"]): Anatomy {
  return { mesial: mesialX(tooth), up };
}

// From mesial, buccal and occlusal to the scene's frame; and back.
export function toScene({ mesial, up, turn }: Anatomy, [m, b, o]: Vector): Vector {
  const v: Vector = up === "buccal" ? [m * mesial, -o, b] : [m * mesial, b, o];
  if (turn === undefined) return v;
  const along = (axis: 0 | 1 | 2) => v[0] * turn[0][axis] + v[1] * turn[1][axis] + v[2] * turn[2][axis];
  return [along(0), along(1), along(2)];
}
export function fromScene({ mesial, up, turn }: Anatomy, v: Vector): Vector {
  const on = (axis: Vector) => v[0] * axis[0] + v[1] * axis[1] + v[2] * axis[2];
  const [x, y, z] = turn === undefined ? v : [on(turn[0]), on(turn[1]), on(turn[2])];
  return up === "buccal" ? [x * mesial, z, -y] : [x * mesial, y, z];
}
