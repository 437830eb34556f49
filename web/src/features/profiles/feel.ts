import type { FeelCell, FeelTissue, ProfileFeel } from "../../api/types";
import { formatNumber } from "../../base/format";
import { spokenLanguage } from "../../base/language";
import { say, sayIf } from "../../base/words";

// The map of what a hand can feel (GET /profiles/{name}/feel), as the page says and compares it.
export type Verdict = FeelCell["verdict"];
export type Motion = FeelCell["motion"];

export const kTones: Readonly<Record<Verdict, "good" | "warning" | "bad" | "neutral">> = {
  felt: "good",
  late: "warning",
  nearly: "warning",
  law_falls_short: "bad",
  device_cannot: "bad",
  beyond_force: "neutral",
};

export const kMotions: readonly Motion[] = ["strokes", "steady"];

export function tissueName(tissue: FeelTissue): string {
  // English names are those of the server, so that only the first begins with a capital.
  const text = tissue.names
    .map((name) => (spokenLanguage() === "en" ? name : (sayIf(`tooth_tissue.${name}`) ?? name)))
    .join(", ");
  return text.charAt(0).toUpperCase() + text.slice(1);
}

export function dampingText(tissue: FeelTissue): string {
  const inN = (mn: number) => formatNumber(mn / 1000, 2);
  const told = {
    damping: inN(tissue.damping_mn_s_per_mm),
    friction: inN(tissue.coulomb_mn),
    threshold: inN(tissue.threshold_mn),
  };
  if (tissue.coulomb_mn > 0)
    return tissue.threshold_mn > 0 ? say("feel.tissue_friction_threshold", told) : say("feel.tissue_friction", told);
  return tissue.threshold_mn > 0 ? say("feel.tissue_threshold", told) : say("feel.tissue_damping", told);
}

export function speedsOf(feel: ProfileFeel): number[] {
  return [...new Set(feel.cells.map((cell) => cell.speed_mm_per_s))].sort((a, b) => a - b);
}

export function cellAt(feel: ProfileFeel, tissue: number, speed: number, motion: Motion): FeelCell | undefined {
  return feel.cells.find((cell) => cell.tissue === tissue && cell.speed_mm_per_s === speed && cell.motion === motion);
}

// "31 % off, 78 ms late"; of a force beyond the motors, how much it would be.
export function figuresText(cell: FeelCell): string {
  if (cell.verdict === "beyond_force") {
    const [mean, most] = [formatNumber(cell.force_rms_n, 1), formatNumber(cell.force_largest_n, 1)];
    return mean === most ? say("feel.needs", { mean }) : say("feel.needs_up_to", { mean, most });
  }
  const error = percent(cell.law.error);
  if (cell.motion === "strokes") return say("feel.off_late", { error, lag: timeText(cell.law.lag_s) });
  return cell.law.rise_s === null
    ? say("feel.off_never", { error })
    : say("feel.off_after", { error, rise: timeText(cell.law.rise_s) });
}

// What the reference track does there, which has the same stiffness and knows the speed.
export function referenceText(cell: FeelCell): string {
  const { error, lag_s: lag, rise_s: rise } = cell.oracle;
  if (cell.motion === "strokes") return say("feel.reference_strokes", { error: percent(error), lag: timeText(lag) });
  return rise === null ? say("feel.reference_never") : say("feel.reference_steady", { rise: timeText(rise) });
}

export interface Difference {
  readonly tissue: FeelTissue;
  readonly motion: Motion;
  readonly speed: number;
  readonly mine: FeelCell;
  readonly other: FeelCell;
}

// Where two devices differ by more than a hand can tell: strokes by the viscosity that is felt (19
// %), a steady cut by its force (7 %), either as a share of the larger; or where only one has the
// force at all. Tissues are matched by what they feel like. What neither can give is not a
// difference.
export function differences(mine: ProfileFeel, other: ProfileFeel): Difference[] {
  return mine.cells.flatMap((cell) => {
    const tissue = mine.tissues[cell.tissue];
    const match = tissue === undefined ? -1 : other.tissues.findIndex((item) => feelsLike(item, tissue));
    const counterpart = match < 0 ? undefined : cellAt(other, match, cell.speed_mm_per_s, cell.motion);
    if (tissue === undefined || counterpart === undefined || !differs(mine, cell, counterpart)) return [];
    return [{ tissue, motion: cell.motion, speed: cell.speed_mm_per_s, mine: cell, other: counterpart }];
  });
}

// How many cells the two maps have in common.
export function comparable(mine: ProfileFeel, other: ProfileFeel): number {
  return mine.cells.filter((cell) => {
    const tissue = mine.tissues[cell.tissue];
    return tissue !== undefined && other.tissues.some((item) => feelsLike(item, tissue));
  }).length;
}

export function thresholdOf(feel: ProfileFeel, name: "force" | "viscosity" | "delay"): number {
  return feel.thresholds.find((threshold) => threshold.name === name)?.value ?? Number.NaN;
}

// The felt share of the right viscosity.
export function feltText(cell: FeelCell): string {
  return cell.verdict === "beyond_force" ? say("feel.too_weak") : percent(cell.law.gain);
}

// "7 % at 0.1; too weak at 0.2, 0.43, 1": speeds with the same text together, in order.
export function bySpeed(items: readonly { readonly speed: number; readonly text: string }[]): string {
  const groups: { text: string; speeds: string[] }[] = [];
  for (const { speed, text } of items) {
    const last = groups.at(-1);
    if (last?.text === text) last.speeds.push(formatNumber(speed, 2));
    else groups.push({ text, speeds: [formatNumber(speed, 2)] });
  }
  return groups
    .map(({ text, speeds }) =>
      say("feel.at_speeds", { text, speeds: speeds.reduce((list, speed) => say("feel.and_speed", { list, speed })) }),
    )
    .join("; ");
}

export function percent(share: number): string {
  return `${formatNumber(100 * share, 0)}\u00a0%`;
}

function differs(feel: ProfileFeel, a: FeelCell, b: FeelCell): boolean {
  const [weakA, weakB] = [a.verdict === "beyond_force", b.verdict === "beyond_force"];
  if (weakA || weakB) return weakA !== weakB;
  const most = Math.max(a.law.gain, b.law.gain);
  return (
    most > 0 &&
    Math.abs(a.law.gain - b.law.gain) > thresholdOf(feel, a.motion === "strokes" ? "viscosity" : "force") * most
  );
}

function feelsLike(a: FeelTissue, b: FeelTissue): boolean {
  return (
    a.damping_mn_s_per_mm === b.damping_mn_s_per_mm &&
    a.coulomb_mn === b.coulomb_mn &&
    a.threshold_mn === b.threshold_mn
  );
}

function timeText(seconds: number | null): string {
  if (seconds === null) return "–";
  return seconds < 1 ? `${formatNumber(1000 * seconds, 0)} ms` : `${formatNumber(seconds, 1)} s`;
}
