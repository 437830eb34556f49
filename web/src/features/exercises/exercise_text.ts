import type { Bur, ExerciseState, ExerciseSummary, TouchCues } from "../../api/types";
import { formatDuration, formatNumber, formatLimit, micrometresAsMm } from "../../base/format";
import { say } from "../../base/words";
import type { Tone } from "../../widgets/basics";

export function burText(burs: readonly Bur[]): string {
  return burs.map((bur) => shapeText(bur) + (bur.iso_number && ` (ISO ${bur.iso_number})`)).join("; ");
}

function shapeText(bur: Bur): string {
  const [shape, across, long] = [
    say(`bur_shape.${bur.shape}`),
    micrometresAsMm(2 * bur.radius_um),
    micrometresAsMm(bur.length_um),
  ];
  if (bur.shape === "sphere") return say("bur_words.plain", { shape, across });
  if (bur.narrow_radius_um === 0) return say("bur_words.long", { shape, across, long });
  return say(bur.shape === "cone" ? "bur_words.at_tip" : "bur_words.at_shank", {
    shape,
    across,
    long,
    narrow: micrometresAsMm(2 * bur.narrow_radius_um),
  });
}

export function shankText({ shank_radius_um: shank, neck_um: neck }: Bur): string {
  if (shank === 0) return say("common.none_there");
  const across = micrometresAsMm(2 * shank);
  return neck > 0
    ? say("bur_words.shank_neck", { across, neck: micrometresAsMm(neck) })
    : say("bur_words.shank", { across });
}

// Small forces beside the cutting force: what they signal, and their strength.
export function touchCuesText(cues: TouchCues | null): string {
  const force = (millinewtons: number) =>
    millinewtons < 100 ? `${formatNumber(millinewtons, 0)} mN` : `${formatNumber(millinewtons / 1000, 2)} N`;
  const [knock, chatter] = [force(cues?.contact_mn ?? 0), force(cues?.chatter_mn ?? 0)];
  if (cues === null || (cues.contact_mn === 0 && cues.chatter_mn === 0)) return say("common.none_there");
  if (cues.chatter_mn === 0) return say("cues.knock", { knock });
  return cues.contact_mn === 0 ? say("cues.chatter", { chatter }) : say("cues.both", { knock, chatter });
}

export function timeLimitText(seconds: number): string {
  return seconds === 0 ? say("common.none_there") : formatDuration(seconds);
}

const kStateTones: Readonly<Record<ExerciseState, Tone>> = { draft: "warning", published: "good", retired: "neutral" };

export function stateText(state: ExerciseState): { readonly title: string; readonly tone: Tone } {
  return { title: say(`exercise_state.${state}`), tone: kStateTones[state] };
}

export function versionText({ version }: { readonly version: number }): string {
  return version === 0 ? say("version.draft") : say("version.number", { number: String(version) });
}

type MarkMap = ReadonlyArray<{ readonly value: number; readonly share: number }>;

// From where on a criterion of the hand costs nothing: one end, or for one that may err to both
// sides, both.
export function fullMarksText(map: MarkMap, unit: string): string {
  const full = map.filter((point) => point.share >= 1).map((point) => point.value);
  const [low, high] = [full.at(0), full.at(-1)];
  if (low === undefined || high === undefined) return "–";
  if (isTwoSided(map)) return rangeText(low, high, unit);
  return formatLimit(falls(map) ? high : low, unit);
}

// From where on it costs all that it can.
export function noMarksText(map: MarkMap, unit: string): string {
  const none = map.filter((point) => point.share <= 0).map((point) => point.value);
  const [low, high] = [none.at(0), none.at(-1)];
  if (low === undefined || high === undefined) return "–";
  if (isTwoSided(map))
    return say("marks.beyond", {
      range: rangeText(
        none.filter((value) => value < middle(map)).at(-1) ?? low,
        none.find((value) => value > middle(map)) ?? high,
        unit,
      ),
    });
  return formatLimit(falls(map) ? low : high, unit);
}

function falls(map: MarkMap): boolean {
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
  return low === -high
    ? `±${formatLimit(high, unit)}`
    : say("marks.range", { low: formatLimit(low, unit), high: formatLimit(high, unit) });
}

// The owner, for instructors.
export function ownerText({ owner, shared }: Pick<ExerciseSummary, "owner" | "shared">): string {
  if (owner == null) return say(shared ? "owner.school_shared" : "owner.school_private");
  return say(shared ? "owner.shared" : "owner.private", { name: owner.display_name });
}
