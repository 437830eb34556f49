import type { MesialX } from "../../api/tooth_number";
import { add, cross, dot, scaled, type Vec } from "../../base/vec";

// How a tooth is turned upright: directions of the mouth in the axes of the file that it came in.

export interface Upright {
  readonly up: Vec; // occlusal; of length 1
  readonly buccal: Vec; // square to it
}
export type MouthAxis = "mesial" | "buccal" | "occlusal";

export function directionOf({ up, buccal }: Upright, mesial: MesialX, axis: MouthAxis): Vec {
  return axis === "occlusal" ? up : axis === "buccal" ? buccal : scaled(cross(buccal, up), mesial);
}

// Turns the tooth in the mouth, counter-clockwise seen from the tip of the axis's arrow. The file's axes turn with the
// tooth, so the mouth's directions turn the other way in the file.
export function turnedAbout(upright: Upright, mesial: MesialX, axis: MouthAxis, degrees: number): Upright {
  const about = directionOf(upright, mesial, axis);
  const [cosine, sine] = exactly(-degrees);
  const turn = (v: Vec): Vec =>
    add(add(scaled(v, cosine), scaled(cross(about, v), sine)), scaled(about, dot(about, v) * (1 - cosine)));
  return { up: turn(upright.up), buccal: turn(upright.buccal) };
}

// Cosine and sine, so that four quarter turns end where they began.
function exactly(degrees: number): readonly [number, number] {
  const exact = (value: number) => (degrees % 90 === 0 ? Math.round(value) : value);
  const rad = (degrees * Math.PI) / 180;
  return [exact(Math.cos(rad)), exact(Math.sin(rad))];
}

// The axes of the scene that `now` would give, in the scene of a tooth that was turned as `shown`.
export function axesIn(shown: Upright, now: Upright): readonly [Vec, Vec, Vec] {
  const axes = ({ up, buccal }: Upright) => [cross(buccal, up), buccal, up] as const;
  const [x, y, z] = axes(shown);
  const seen = (v: Vec): Vec => [dot(v, x), dot(v, y), dot(v, z)];
  const [right, front, above] = axes(now);
  return [seen(right), seen(front), seen(above)];
}

// As an import takes it.
export function directionText(direction: Vec): string {
  return direction.map((part) => Number(part.toFixed(6))).join(",");
}
