import type { MesialX } from "../../api/tooth_number";
import type { PointMm } from "../../tooth/messages";

// From where a tooth is looked at first: from above, mesial and lingual. `mesial` undefined: not known yet.
export function angledFrom(mesial: MesialX | undefined): PointMm {
  return [0.5 * (mesial ?? 1), -0.6, 0.9];
}
