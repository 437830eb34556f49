import type { AttemptDetail, AttemptFacts, Criterion, Hand, Region, Score } from "../../api/types";
import { cariesLeft, stoppedEarly } from "../../widgets/attempt_state";
import { formatNumber, formatPoints, formatScore } from "../../base/format";
import { criterionTitle, reasonText } from "../../api/worded";
import { say, sayIf } from "../../base/words";

export const kPointsShown = 0.05; // lost points below this round to zero

type GradeGroup = Criterion["group"];

export interface GroupLoss {
  readonly group: GradeGroup;
  readonly title: string;
  readonly lost: number; // points
  readonly state: Criterion["state"]; // of the worst of its parts
  readonly regions: readonly Region[]; // the dearest first
  readonly criteria: readonly Criterion[]; // of the hand, the dearest first
}

const kStates: readonly Criterion["state"][] = ["acceptable", "modify", "redo"];

// What each group cost, in the score's order.
export function groupsOf({ criteria, regions }: Pick<Score, "criteria" | "regions">): GroupLoss[] {
  const groups = [...new Set(criteria.map(({ group }) => group))];
  return groups.map((group) => {
    const judged = criteria.filter((criterion) => criterion.group === group);
    const states = judged.map(({ state }) => kStates.indexOf(state));
    return {
      group,
      title: criterionTitle({ name: group, title: judged[0]?.title ?? group }),
      lost: judged.reduce((sum, { lost }) => sum + lost, 0),
      state: kStates[Math.max(0, ...states)] ?? "acceptable",
      regions: dearestFirst(regions.filter((region) => region.group === group)),
      criteria: group === "hand" ? dearestFirst(judged) : [],
    };
  });
}

function dearestFirst<T extends { readonly lost: number }>(items: readonly T[]): T[] {
  return [...items].sort((a, b) => b.lost - a.lost);
}

// Why the attempt is not acceptable: errors of the rubric's list, and criteria beyond the value that fails the whole.
export function failures({ critical, criteria }: Pick<Score, "critical" | "criteria">): string[] {
  const beyond = criteria.filter(({ reasons }) => reasons?.some(({ code }) => code === "fails_above"));
  return [...critical.map(({ reason }) => reason), ...beyond.map(reasonText)];
}

// One or two sentences that say what happened.
export function summarySentence(score: Score): string {
  const total = formatScore(score.score);
  if (score.critical_fail) return say("summary.critical", { score: total });
  const done = stoppedEarly(score);
  if (done !== undefined) return say("summary.stopped", { score: total, percent: formatNumber(done, 0) });
  const caries = cariesLeft(score);
  if (caries !== undefined && score.mistakes[0]?.kind === "caries")
    return say("summary.caries", { score: total, percent: formatNumber(caries, 0) });
  const [worst, second] = dearestFirst(groupsOf(score)).filter(({ lost }) => lost >= kPointsShown);
  if (worst === undefined) return say("summary.full", { score: total });
  if (second === undefined) return say("summary.one", { score: total, worst: inSentence(worst) });
  return say("summary.two", { score: total, worst: inSentence(worst), second: inSentence(second) });
}

function inSentence({ title, lost }: GroupLoss): string {
  return say("summary.lost_on", { title, points: formatPoints(lost) });
}

// Scored, and not to be seen by the student yet: score, tooth, forces and remarks come with the
// release.
export function isWithheld(
  { state, computed_score: computed }: Pick<AttemptDetail, "state" | "computed_score">,
  teacher: boolean,
): boolean {
  return !teacher && state === "scored" && computed === null;
}

export function withheldText({ exam }: Pick<AttemptDetail, "exam">): string {
  return say(exam ? "withheld.exam" : "withheld.graded");
}

export interface RecordingFacts {
  readonly complete: boolean; // nothing lost, and the replay repeats the recording
  readonly headline: string;
  readonly details: readonly string[];
}

// What became of the recording on its way: gaps, late ticks, the replay's agreement.
export function recordingFacts(attempt: AttemptDetail, score: Score | undefined): RecordingFacts {
  const gaps = score?.gap_ticks ?? attempt.gap_ticks;
  const ticks = score?.ticks ?? attempt.ticks;
  const details: string[] = [];
  if (gaps > 0)
    details.push(
      say("recording.gap_ticks", { count: gaps, percent: formatNumber((100 * gaps) / Math.max(1, ticks + gaps), 2) }),
    );
  if (score !== undefined) {
    if (!score.witness_ok)
      details.push(
        score.witness_note === ""
          ? say("recording.not_repeated")
          : say("recording.not_repeated_note", { note: score.witness_note }),
      );
    if (score.outages > 0)
      details.push(
        say("recording.outages", {
          count: score.outages,
          per_hour: formatNumber((3600 * score.outages) / Math.max(1, attempt.duration_s), 1),
        }),
      );
    if (score.late_ticks > 0) details.push(say("recording.late", { count: score.late_ticks }));
    if (score.bounded_ticks > 0) details.push(say("recording.limited", { count: score.bounded_ticks }));
    details.push(...disturbance(score));
  }
  const complete = gaps === 0 && score?.witness_ok !== false;
  return { complete, headline: headline(complete, score), details };
}

// That the station got in the way, with its figures; nothing is taken off for it.
function disturbance({ disturbance: d }: Score): string[] {
  if (d?.disturbed !== true) return [];
  const share = (percent: number): string => `${formatNumber(percent, 1)} %`;
  return [
    say("recording.disturbed_by", {
      late: share(d.late_percent),
      missing: share(d.gap_percent),
      limited: share(d.limited_percent),
    }),
  ];
}

// What held the tool, as the signed recording says.
export function heldBy({ kind, device, driver, unit }: Hand): string {
  switch (kind) {
    case "program":
      return say("hand.simulated", { driver: driver.replace(/^operator /, "") });
    case "haptic":
      return unit === "" ? device : `${device} (${unit})`;
    case "pointer":
      return device;
    default:
      return say("hand.not_told");
  }
}

// What the station said of the attempt, by the API's own names: a new fact needs nothing here. What
// was not said is not shown, and neither is what a newer server tells in a way that has no line.
export function saidFacts(facts: AttemptFacts): { readonly name: string; readonly value: string }[] {
  return Object.entries(facts).flatMap(([key, value]: [string, unknown]) => {
    const words = key.replaceAll("_", " ");
    const name = sayIf(`fact.${key}`) ?? words.charAt(0).toUpperCase() + words.slice(1);
    if (value === true) return [{ name, value: say("editor.yes") }];
    if (typeof value === "number" && value !== 0) return [{ name, value: formatNumber(value, 3) }];
    return typeof value === "string" && value !== "" ? [{ name, value }] : [];
  });
}

function headline(complete: boolean, score: Score | undefined): string {
  if (!complete) return say("recording.was_disturbed");
  return score === undefined ? say("recording.nothing_lost") : say("recording.repeats");
}
