import { type Json, valueAt } from "../../base/document";

// Instructions of an exercise give lengths of its target in words. Nothing ties them to the target's numbers: whoever
// changes a depth, as in a copy, has to change the text too.

export interface StaleLength {
  readonly said: string; // "2.0 mm", as the text has it
  readonly now: string; // "1.5 mm", with as many decimals or more
}

const kLength = /(\d+(?:[.,]\d+)?)(\s?mm)\b/g;

// Lengths in the instructions that the target had when it was read and has no longer.
export function staleLengths(read: Json, now: Json): readonly StaleLength[] {
  const text = valueAt(now, ["instructions"]);
  if (typeof text !== "string") return [];
  const is = lengthsIn(valueAt(now, ["target"]));
  const changed = new Map<number, number>(); // µm, as read and now
  for (const [place, before] of lengthsIn(valueAt(read, ["target"]))) {
    const after = is.get(place);
    if (after !== undefined && after !== before) changed.set(before, after);
  }
  const found = new Map<string, StaleLength>();
  for (const [said, number = "", unit = ""] of text.matchAll(kLength)) {
    const um = changed.get(Math.round(1000 * Number(number.replace(",", "."))));
    if (um === undefined) continue;
    const digits = number.split(/[.,]/)[1]?.length ?? 0;
    const least = String(um / 1000).split(".")[1]?.length ?? 0;
    const shown = (um / 1000).toFixed(Math.max(digits, least));
    found.set(said, { said, now: (number.includes(",") ? shown.replace(".", ",") : shown) + unit });
  }
  return [...found.values()];
}

// By place, µm. A text gives the whole of what is stored as a half.
function lengthsIn(value: Json | undefined, place = "", times = 0): ReadonlyMap<string, number> {
  if (typeof value === "number") return times === 0 ? new Map() : new Map([[place, times * value]]);
  if (typeof value !== "object" || value === null) return new Map();
  return new Map(
    Object.entries(value).flatMap(([member, inner]) => [
      ...lengthsIn(
        inner as Json,
        `${place} ${member}`,
        member.endsWith("_um") ? (member === "half_size_um" ? 2 : 1) : times,
      ),
    ]),
  );
}

// The text with the lengths of now.
export function mendedText(text: string, stale: readonly StaleLength[]): string {
  return text.replaceAll(kLength, (said) => stale.find((each) => each.said === said)?.now ?? said);
}
