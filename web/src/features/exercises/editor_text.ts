import { type Change, type Json, valueAt } from "../../base/document";
import { say, sayIf } from "../../base/words";
import type { Option } from "../../widgets/form";

// What places of an exercise document are called, for people.

// "Rubric, Mesial wall, points".
export function placeTitle({ path, before, after }: Change, document: Json): string {
  const words: string[] = [];
  path.forEach((step, i) => {
    if (typeof step === "string") {
      // The lists are told by what stands in them.
      if (!((step === "criteria" || step === "gates") && typeof path[i + 1] === "number")) words.push(sayIf(`document_place.${step}`) ?? step);
      return;
    }
    const here = i === path.length - 1 ? after ?? before : valueAt(document, path.slice(0, i + 1));
    const title = here === undefined ? undefined : valueAt(here, ["title"]);
    words.push(typeof title === "string" ? title : `${step + 1}`);
  });
  const place = words.join(", ");
  if (before === undefined) return say("place_changed.added", { place });
  return after === undefined ? say("place_changed.removed", { place }) : place;
}

const kShapes = ["sphere", "cylinder", "cone", "inverted_cone", "pear", "flame", "wheel"] as const;

export function shapeOptions(): readonly Option[] {
  return kShapes.map((value) => ({ value, title: say(`bur_shape.${value}`) }));
}
