import { sayIf } from "./words";

const kAcronyms = /\b(rms|dtw|iou)\b/g;

// What a measurement is called. One that this page does not know, of an older or newer server, by
// its name without the unit.
export function metricTitle(name: string, unit: string): string {
  const known = sayIf(`metric.${name}`);
  if (known !== undefined) return known;
  const suffix = unit === "%" ? "_percent" : `_${unit.toLowerCase().replaceAll("/", "_per_").replaceAll(" ", "_")}`;
  const stem = name.toLowerCase().endsWith(suffix) ? name.slice(0, -suffix.length) : name;
  const words = stem
    .replaceAll("_", " ")
    .trim()
    .replace(kAcronyms, (word) => word.toUpperCase());
  return words.charAt(0).toUpperCase() + words.slice(1);
}
