import { changesBetween, type Json, valueAt } from "../../base/document";

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
  const changed = new Map<number, number>(); // µm, as read and now
  for (const { path, before, after } of changesBetween(valueAt(read, ["target"]), valueAt(now, ["target"])))
    if (typeof before === "number" && typeof after === "number") {
      const times = path.includes("half_size_um") ? 2 : 1; // a text gives the whole
      if (path.some((step) => typeof step === "string" && step.endsWith("_um")))
        changed.set(times * before, times * after);
    }
  const found = new Map<string, StaleLength>();
  for (const [said, number = "", unit = ""] of text.matchAll(kLength)) {
    const is = changed.get(Math.round(1000 * Number(number.replace(",", "."))));
    if (is === undefined) continue;
    const digits = number.split(/[.,]/)[1]?.length ?? 0;
    const least = String(is / 1000).split(".")[1]?.length ?? 0;
    const shown = (is / 1000).toFixed(Math.max(digits, least));
    found.set(said, { said, now: (number.includes(",") ? shown.replace(".", ",") : shown) + unit });
  }
  return [...found.values()];
}

// The text with the lengths of now.
export function mendedText(text: string, stale: readonly StaleLength[]): string {
  return text.replaceAll(kLength, (said) => stale.find((each) => each.said === said)?.now ?? said);
}
