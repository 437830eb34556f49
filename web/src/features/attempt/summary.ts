import type { AttemptDetail, AttemptFacts, Criterion, Hand, Score } from "../../api/types";
import { stoppedEarly } from "../../widgets/attempt_state";
import { formatNumber, formatPoints, formatQuantity, formatScore, plural } from "../../base/format";

const kPointsShown = 0.05;                      // lost points below this round to zero

export function lostPoints(criterion: Criterion): number {
  return Math.max(0, criterion.max_points - criterion.points);
}

// Where points were lost first, most lost on top; full marks after, as the rubric has them.
export function byLostPoints(criteria: readonly Criterion[]): Criterion[] {
  return [...criteria].sort((a, b) => lostPoints(b) - lostPoints(a));
}

// One or two sentences that say what happened.
export function summarySentence(score: Score): string {
  const total = `${formatScore(score.score)} of 100.`;
  if (score.critical_fail) return `${total} A critical criterion failed, so the whole attempt counts as not passed.`;
  const done = stoppedEarly(score);
  if (done !== undefined) return `${total} The work was stopped early: ${formatNumber(done, 0)} % of it was done, so every criterion counts less.`;
  const judged = score.criteria.filter((criterion) => criterion.max_points > 0);
  const lost = byLostPoints(judged).filter((criterion) => lostPoints(criterion) >= kPointsShown);
  const [worst, second] = lost;
  if (worst === undefined) return `${total} Full marks in every criterion.`;
  const first = `${total} Most points were lost on ${inSentence(worst)}`;
  const kept = judged.length - lost.length;
  const rest = kept > 0 ? ` Full marks in ${formatNumber(kept, 0)} of ${plural(judged.length, "criterion", "criteria")}.` : "";
  return `${first}${second === undefined ? "" : `, then on ${inSentence(second)}`}.${rest}`;
}

function inSentence(criterion: Criterion): string {
  return `“${criterion.title}” (${formatQuantity(criterion.value, criterion.unit)}, −${formatPoints(lostPoints(criterion))})`;
}

// Scored, and not to be seen by the student yet: score, tooth, forces and remarks come with the release.
export function isWithheld({ state, computed_score: computed }: Pick<AttemptDetail, "state" | "computed_score">, teacher: boolean): boolean {
  return !teacher && state === "scored" && computed === null;
}

export function withheldText({ exam }: Pick<AttemptDetail, "exam">): string {
  return `This is ${exam ? "an exam" : "graded work"}. It is scored. Score, picture, forces and remarks appear here as soon as your instructor releases them.`;
}

export interface RecordingFacts {
  readonly complete: boolean;                   // nothing lost, and the replay repeats the recording
  readonly headline: string;
  readonly details: readonly string[];
}

// What became of the recording on its way: gaps, late ticks, the replay's agreement.
export function recordingFacts(attempt: AttemptDetail, score: Score | undefined): RecordingFacts {
  const gaps = score?.gap_ticks ?? attempt.gap_ticks;
  const ticks = score?.ticks ?? attempt.ticks;
  const details: string[] = [];
  if (gaps > 0) details.push(`${plural(gaps, "tick")} (${formatNumber((100 * gaps) / Math.max(1, ticks + gaps), 2)} %) were not recorded; the gaps are declared and were not scored.`);
  if (score !== undefined) {
    if (!score.witness_ok) details.push(`The replay does not repeat what the station recorded${score.witness_note === "" ? "" : `: ${score.witness_note}`}. The score needs a person's judgement.`);
    if (score.late_ticks > 0) details.push(`${plural(score.late_ticks, "tick")} came late.`);
    if (score.bounded_ticks > 0) details.push(`The device's force limit acted in ${plural(score.bounded_ticks, "tick")}.`);
    details.push(...disturbance(score));
  }
  const complete = gaps === 0 && score?.witness_ok !== false;
  return { complete, headline: headline(complete, score), details };
}

// That the station got in the way, with its figures; nothing is taken off for it.
function disturbance({ disturbance: d }: Score): string[] {
  if (d?.disturbed !== true) return [];
  const share = (percent: number): string => `${formatNumber(percent, 1)} %`;
  return [`The station disturbed the attempt: ${share(d.late_percent)} of its ticks came late, ${share(d.gap_percent)} of its time is missing, and the device was at its limit in ${share(d.limited_percent)} of the time with force.`];
}

// What held the tool, as the signed recording says.
export function heldBy({ kind, device, driver, unit }: Hand): string {
  switch (kind) {
    case "program": return `A simulated hand (${driver})`;
    case "haptic": return unit === "" ? device : `${device} (${unit})`;
    case "pointer": return device;
    default: return "Not told by the station";
  }
}

// What the station said of the attempt, by the API's own names: a new fact needs nothing here. What was not said is not
// shown, and neither is what a newer server tells in a way that has no line.
export function saidFacts(facts: AttemptFacts): { readonly name: string; readonly value: string }[] {
  return Object.entries(facts).flatMap(([key, value]: [string, unknown]) => {
    const words = key.replaceAll("_", " ");
    const name = words.charAt(0).toUpperCase() + words.slice(1);
    if (value === true) return [{ name, value: "Yes" }];
    if (typeof value === "number" && value !== 0) return [{ name, value: formatNumber(value, 3) }];
    return typeof value === "string" && value !== "" ? [{ name, value }] : [];
  });
}

function headline(complete: boolean, score: Score | undefined): string {
  if (!complete) return "The recording was disturbed";
  return score === undefined ? "Nothing was lost" : "Nothing was lost, and the replay repeats the recording exactly";
}
