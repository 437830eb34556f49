import { type Anatomy, toScene } from "../../api/tooth_number";
import type { Axis, Plane, PointMm } from "../../tooth/messages";

// The sides from which a tooth is drawn where no 3-D picture can be. Mesial, buccal, occlusal: towards the eye, and up.
export const kStillSides = [
  { side: "occlusal", towards: [0, 0, 1], up: [0, 1, 0] },
  { side: "buccal", towards: [0, 1, 0], up: [0, 0, 1] },
  { side: "lingual", towards: [0, -1, 0], up: [0, 0, 1] },
  { side: "mesial", towards: [1, 0, 0], up: [0, 0, 1] },
  { side: "distal", towards: [-1, 0, 0], up: [0, 0, 1] },
] as const;

// The plane that is seen from a side, in the scene's axes.
export function stillPlane(anatomy: Anatomy, towards: PointMm, up: PointMm): Plane {
  const [t, u] = [toScene(anatomy, towards), toScene(anatomy, up)];
  const right: PointMm = [u[1] * t[2] - u[2] * t[1], u[2] * t[0] - u[0] * t[2], u[0] * t[1] - u[1] * t[0]];
  const [across, along] = [axisOf(right), axisOf(u)];
  return { right: across, up: along, against: [right[across] < 0, u[along] < 0] };
}

function axisOf(way: PointMm): Axis {
  return way.findIndex((part) => Math.abs(part) > 0.5) as Axis;
}
