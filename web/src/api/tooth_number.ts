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
}

type Vector = readonly [number, number, number];

export function anatomyOf({ tooth, up }: Exercise["target"]): Anatomy {
  return { mesial: mesialX(tooth), up };
}

// From mesial, buccal and occlusal to the scene's frame; and back.
export function toScene({ mesial, up }: Anatomy, [m, b, o]: Vector): Vector {
  return up === "buccal" ? [m * mesial, -o, b] : [m * mesial, b, o];
}
export function fromScene({ mesial, up }: Anatomy, [x, y, z]: Vector): Vector {
  return up === "buccal" ? [x * mesial, z, -y] : [x * mesial, y, z];
}
