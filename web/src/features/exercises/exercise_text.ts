import type { Bur, ExerciseState, ExerciseSummary, TouchCues } from "../../api/types";
import { formatDuration, formatNumber, formatLimit, micrometresAsMm } from "../../base/format";
import type { Tone } from "../../widgets/basics";

const kShapes: Readonly<Record<Bur["shape"], string>> = {
  sphere: "Round", cylinder: "Cylinder", cone: "Cone", inverted_cone: "Inverted cone", pear: "Pear", flame: "Flame", wheel: "Wheel",
};

export function burText(bur: Bur): string {
  const narrow = bur.narrow_radius_um > 0 ? `, ${micrometresAsMm(2 * bur.narrow_radius_um)} at the ${bur.shape === "cone" ? "tip" : "shank"}` : "";
  const length = bur.shape === "sphere" ? "" : `, ${micrometresAsMm(bur.length_um)} long`;
  return `${kShapes[bur.shape]}, ${micrometresAsMm(2 * bur.radius_um)} across${narrow}${length}`;
}

export function shankText({ shank_radius_um: shank, neck_um: neck }: Bur): string {
  if (shank === 0) return "None";
  return `${micrometresAsMm(2 * shank)} across${neck > 0 ? `, neck ${micrometresAsMm(neck)}` : ""}`;
}

// Small forces beside the cutting force: what they tell of and how strong they get.
export function touchCuesText(cues: TouchCues | null): string {
  if (cues === null) return "None";
  const newtons = (millinewtons: number) => millinewtons < 100 ? `up to ${formatNumber(millinewtons, 0)} mN` : `up to ${formatNumber(millinewtons / 1000, 2)} N`;
  const knock = cues.contact_mn > 0 ? `A knock on contact, ${newtons(cues.contact_mn)}` : "";
  const chatter = cues.chatter_mn > 0 ? `${knock === "" ? "The" : "the"} bur's chatter, ${newtons(cues.chatter_mn)}` : "";
  return `${[knock, chatter].filter((part) => part !== "").join("; ")}. Not counted in the score`;
}

export function timeLimitText(seconds: number): string {
  return seconds === 0 ? "None" : formatDuration(seconds);
}

export const kStateTexts: Readonly<Record<ExerciseState, { readonly title: string; readonly tone: Tone }>> = {
  draft: { title: "Draft", tone: "warning" }, published: { title: "Published", tone: "good" }, retired: { title: "Retired", tone: "neutral" },
};

export function versionText({ version }: { readonly version: number }): string {
  return version === 0 ? "draft" : `version ${version}`;
}

type MarkMap = ReadonlyArray<{ readonly value: number; readonly share: number }>;

// From where on a criterion gives all of its points: one end, or for one that may err to both sides, both.
export function fullMarksText(map: MarkMap, unit: string): string {
  const full = map.filter((point) => point.share >= 1).map((point) => point.value);
  const [low, high] = [full.at(0), full.at(-1)];
  if (low === undefined || high === undefined) return "–";
  if (isTwoSided(map)) return rangeText(low, high, unit);
  return formatLimit(falls(map) ? high : low, unit);
}

// From where on it gives none.
export function noMarksText(map: MarkMap, unit: string): string {
  const none = map.filter((point) => point.share <= 0).map((point) => point.value);
  const [low, high] = [none.at(0), none.at(-1)];
  if (low === undefined || high === undefined) return "–";
  if (isTwoSided(map)) return `beyond ${rangeText(none.filter((value) => value < middle(map)).at(-1) ?? low, none.find((value) => value > middle(map)) ?? high, unit)}`;
  return formatLimit(falls(map) ? low : high, unit);
}

export function falls(map: MarkMap): boolean {
  return (map.at(0)?.share ?? 0) >= (map.at(-1)?.share ?? 0);
}

function isTwoSided(map: MarkMap): boolean {
  const most = Math.max(...map.map((point) => point.share));
  return (map.at(0)?.share ?? 0) < most && (map.at(-1)?.share ?? 0) < most;
}

function middle(map: MarkMap): number {
  return map.reduce((best, point) => (point.share > best.share ? point : best), map[0] ?? { value: 0, share: 0 }).value;
}

function rangeText(low: number, high: number, unit: string): string {
  return low === -high ? `±${formatLimit(high, unit)}` : `${formatLimit(low, unit)} to ${formatLimit(high, unit)}`;
}

// Whose it is, for who teaches.
export function ownerText({ owner, shared }: Pick<ExerciseSummary, "owner" | "shared">): string {
  return `${owner?.display_name ?? "The school"}, ${shared ? "shared" : "private"}`;
}
