import { wordedTitle } from "../../api/builtin_words";
import { type Change, type Json, type Path, pathText, valueAt } from "../../base/document";
import { formatNumber } from "../../base/format";
import { say, sayIf } from "../../base/words";
import type { Option } from "../../widgets/form";

// What places of an exercise document are called, for people.

// "Rubric, Mesial wall, points".
export function placeTitle({ path, before, after }: Change, document: Json): string {
  const place = placeWords(path, document, after ?? before);
  if (before === undefined) return say("place_changed.added", { place });
  return after === undefined ? say("place_changed.removed", { place }) : place;
}

// `last`: the value there, or the removed one.
export function placeWords(path: Path, document: Json, last: Json | undefined = valueAt(document, path)): string {
  const words: string[] = [];
  path.forEach((step, i) => {
    if (typeof step === "string") {
      // Lists are named after their items.
      if (!((step === "criteria" || step === "gates") && typeof path[i + 1] === "number"))
        words.push(sayIf(`document_place.${step}`) ?? step);
      return;
    }
    if (typeof path[i - 1] === "number") return; // in a row
    const here = i === path.length - 1 ? last : valueAt(document, path.slice(0, i + 1));
    const title = here === undefined ? undefined : valueAt(here, ["title"]);
    words.push(typeof title === "string" && title !== "" ? wordedTitle(title) : `${step + 1}`);
  });
  return words.join(", ");
}

const kMostPoints = 1000; // of a criterion, and
const kMostLimit = 1e9; // how far a limit may lie: schemas/rubric.schema.json

// Numbers of a rubric that are none or out of bounds, by place: what the page can say in its own
// words before the server does.
export function rubricProblems(document: Json, rubric: Path): ReadonlyMap<string, string> {
  const found = new Map<string, string>();
  const look = (path: Path, least: number, most: number, shown = 1) => {
    const value = valueAt(document, path);
    if (typeof value !== "number") found.set(pathText(path), say("editor.a_number"));
    else if (value < least || value > most)
      found.set(
        pathText(path),
        say("editor.number_from_to", { least: formatNumber(least * shown, 0), most: formatNumber(most * shown, 0) }),
      );
  };
  for (const list of ["criteria", "gates"]) {
    const items = valueAt(document, [...rubric, list]);
    (Array.isArray(items) ? (items as readonly Json[]) : []).forEach((item, i) => {
      const path = [...rubric, list, i];
      if (list === "criteria") look([...path, "points"], 0, kMostPoints);
      if (valueAt(item, ["fails_above"]) !== undefined) look([...path, "fails_above"], -kMostLimit, kMostLimit);
      const rows = valueAt(item, ["map"]);
      (Array.isArray(rows) ? (rows as readonly Json[]) : []).forEach((_row, row) => {
        look([...path, "map", row, 0], -Infinity, Infinity);
        look([...path, "map", row, 1], 0, 1, 100);
      });
    });
  }
  return found;
}

const kShapes = ["sphere", "cylinder", "cone", "inverted_cone", "pear", "flame", "wheel"] as const;

export function shapeOptions(): readonly Option[] {
  return kShapes.map((value) => ({ value, title: say(`bur_shape.${value}`) }));
}

// Materials with tolerances in a rubric, and the one that it names; none first.
export function materialOptions(restorations: Json | undefined, named: Json | undefined): readonly Option[] {
  const names = (Array.isArray(restorations) ? (restorations as readonly Json[]) : []).map((each) =>
    valueAt(each, ["restoration"]),
  );
  return [
    { value: "", title: say("restoration.not_named") },
    ...[...new Set([...names, named])]
      .filter((name) => typeof name === "string")
      .map((value) => ({ value, title: sayIf(`material.${value}`) ?? value })),
  ];
}

// By the rows of an item, which are value and share: above a limit such an item would fail its best attempts.
export function moreIsBetter(item: Json): boolean {
  const map = valueAt(item, ["map"]);
  const shares = Array.isArray(map) ? map.map((row: Json) => Number(valueAt(row, [1]))) : [];
  return (shares.at(-1) ?? 0) > (shares[0] ?? 0);
}
