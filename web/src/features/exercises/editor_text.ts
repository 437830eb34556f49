import { wordedTitle } from "../../api/builtin_words";
import { type Change, type Json, type Path, pathText, valueAt } from "../../base/document";
import { formatNumber, formatPoints } from "../../base/format";
import { say, sayIf } from "../../base/words";
import type { Option } from "../../widgets/form";
import { kSides, measuredOf, priceTitle } from "./price";

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
      if (!((step === "criteria" || step === "prices") && typeof path[i + 1] === "number"))
        words.push(sayIf(`document_place.${step}`) ?? step);
      return;
    }
    if (typeof path[i - 1] === "number") return; // in a row
    const here = i === path.length - 1 ? last : valueAt(document, path.slice(0, i + 1));
    words.push((here === undefined ? "" : itemTitle(here)) || `${step + 1}`);
  });
  return words.join(", ");
}

// Of a criterion, or of what a price is for.
function itemTitle(item: Json): string {
  const [title, of] = [valueAt(item, ["title"]), valueAt(item, ["of"])];
  if (typeof of === "string") return priceTitle(of);
  return typeof title === "string" ? wordedTitle(title) : "";
}

export function itemsAt(list: Json | undefined): readonly Json[] {
  return Array.isArray(list) ? (list as readonly Json[]) : [];
}

// Of schemas/rubric.schema.json: the points of a criterion, how far a limit may lie, and the points and sizes of a price.
const kMaxPoints = 1000;
const kMaxLimit = 1e9;
const kMaxPrice = 10_000;
const kMaxSize = 1000;

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
  itemsAt(valueAt(document, [...rubric, "criteria"])).forEach((item, i) => {
    const path = [...rubric, "criteria", i];
    look([...path, "points"], 0, kMaxPoints);
    if (valueAt(item, ["fails_above"]) !== undefined) look([...path, "fails_above"], -kMaxLimit, kMaxLimit);
    itemsAt(valueAt(item, ["map"])).forEach((_row, row) => {
      look([...path, "map", row, 0], -Infinity, Infinity);
      look([...path, "map", row, 1], 0, 1, 100);
    });
  });
  itemsAt(valueAt(document, [...rubric, "prices"])).forEach((item, i) => {
    for (const [member, problem] of priceProblems(item)) found.set(pathText([...rubric, "prices", i, member]), problem);
  });
  return found;
}

function priceProblems(item: Json): ReadonlyMap<string, string> {
  const found = new Map<string, string>();
  const measured = measuredOf(valueAt(item, ["of"]));
  const numberAt = (member: string, largest: number): number | undefined => {
    const value = valueAt(item, [member]);
    if (typeof value !== "number") found.set(member, say("editor.a_number"));
    else if (value <= 0) found.set(member, say("price.above_zero"));
    else if (value > largest)
      found.set(member, say("editor.number_from_to", { least: "0", most: formatNumber(largest, 0) }));
    else return value;
    return undefined;
  };
  const [over, left] = kSides.map((side) => {
    const member = measured?.[side];
    return member === undefined ? undefined : numberAt(member, kMaxSize);
  });
  // What was left can still be removed.
  if (over !== undefined && left !== undefined && over > left)
    found.set(measured?.over ?? "", say("price.over_at_most", { size: formatNumber(left, 4) }));
  const [points, most, modify, redo] = ["points", "most", "modify_points", "redo_points"].map((member) =>
    numberAt(member, kMaxPrice),
  );
  if (points !== undefined && most !== undefined && most < points)
    found.set("most", say("price.at_least", { points: formatPoints(points) }));
  if (modify !== undefined && redo !== undefined && redo <= modify)
    found.set("redo_points", say("price.more_than", { points: formatPoints(modify) }));
  return found;
}

// Kinds for which the named material has prices of its own, which count in place of the rubric's.
export function materialPrices(rubric: Json | undefined): ReadonlySet<string> {
  const named = rubric === undefined ? undefined : valueAt(rubric, ["restoration"]);
  const material = itemsAt(rubric === undefined ? undefined : valueAt(rubric, ["restorations"])).find(
    (each) => typeof named === "string" && valueAt(each, ["restoration"]) === named,
  );
  return new Set(
    itemsAt(material === undefined ? undefined : valueAt(material, ["prices"])).map((price) =>
      String(valueAt(price, ["of"])),
    ),
  );
}

const kShapes = ["sphere", "cylinder", "cone", "inverted_cone", "pear", "flame", "wheel"] as const;

export function shapeOptions(): readonly Option[] {
  return kShapes.map((value) => ({ value, title: say(`bur_shape.${value}`) }));
}

// Materials with tolerances in a rubric, and the one that it names; none first.
export function materialOptions(restorations: Json | undefined, named: Json | undefined): readonly Option[] {
  const names = itemsAt(restorations).map((each) => valueAt(each, ["restoration"]));
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
