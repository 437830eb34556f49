import type { Exercise } from "../../api/types";
import { type Json, valueAt } from "../../base/document";

type Target = Exercise["target"];

const kMeasures = [
  ["half_size_um", 0],
  ["half_size_um", 1],
  ["depth_um"],
  ["leeway_side_um"],
  ["leeway_bottom_um"],
] as const;

// The target of a document, where the server says that the exercise's own one hangs; nowhere, if the document names
// another landmark. Undefined: a measure is no number that can be drawn.
export function drawnTarget(own: Target, document: Json | undefined): Target | undefined {
  if (document === undefined) return undefined;
  const [length, width, depth, side, bottom] = kMeasures.map((path) => valueAt(document, path));
  if (!isAbove(length) || !isAbove(width) || !isAbove(depth)) return undefined;
  if (!isAtLeastNone(side) || !isAtLeastNone(bottom)) return undefined;
  const parts = valueAt(document, ["parts"]);
  return {
    ...own,
    landmark_um: valueAt(document, ["landmark"]) === own.landmark ? own.landmark_um : null,
    half_size_um: [length, width, 0],
    depth_um: depth,
    leeway_side_um: side,
    leeway_bottom_um: bottom,
    parts: Array.isArray(parts) ? (parts as unknown as Target["parts"]) : [],
  };
}

function isAtLeastNone(value: Json | undefined): value is number {
  return typeof value === "number" && value >= 0;
}
function isAbove(value: Json | undefined): value is number {
  return isAtLeastNone(value) && value > 0;
}
