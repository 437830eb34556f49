import { type Change, type Json, valueAt } from "../../base/document";

// What places of an exercise document are called, for people.

const kTitles: Readonly<Record<string, string>> = {
  title: "Title", instructions: "What students read", graded: "Graded", time_limit_s: "Time limit, s", name: "Name", law: "Force law", rate_hz: "Loop rate, Hz", scene_sha256: "Tooth",
  bur: "Bur", handpiece: "Handpiece", touch_cues: "Touch cues", target: "Target", rubric: "Rubric", criteria: "Criteria", gates: "Gates", parts: "Parts",
  shape: "shape", radius_um: "radius, µm", length_um: "length, µm", narrow_radius_um: "narrow radius, µm", shank_radius_um: "shank radius, µm", neck_um: "neck, µm",
  landmark: "landmark", half_size_um: "half length and width, µm", depth_um: "depth, µm", leeway_side_um: "beyond the walls, µm", leeway_bottom_um: "below the floor, µm", container_um: "must stay around, µm",
  metric: "measured", points: "points", map: "full and no marks", comment: "advice", fails_above: "fails above", unit: "unit", version: "Version", format: "Format",
};

// "Rubric, Mesial wall, points".
export function placeTitle({ path, before, after }: Change, document: Json): string {
  const words: string[] = [];
  path.forEach((step, i) => {
    if (typeof step === "string") {
      // The lists are told by what stands in them.
      if (!((step === "criteria" || step === "gates") && typeof path[i + 1] === "number")) words.push(kTitles[step] ?? step);
      return;
    }
    const here = i === path.length - 1 ? after ?? before : valueAt(document, path.slice(0, i + 1));
    const title = here === undefined ? undefined : valueAt(here, ["title"]);
    words.push(typeof title === "string" ? title : `${step + 1}`);
  });
  if (before === undefined) words.push("added");
  if (after === undefined) words.push("removed");
  return words.join(", ");
}

export const kShapes = [
  { value: "sphere", title: "Ball" }, { value: "cylinder", title: "Cylinder" }, { value: "cone", title: "Cone" }, { value: "inverted_cone", title: "Inverted cone" },
  { value: "pear", title: "Pear" }, { value: "flame", title: "Flame" }, { value: "wheel", title: "Wheel" },
] as const;
