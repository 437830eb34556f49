import type { Attempt, AttemptFlag, AttemptState, Hand, Mistake, Score } from "../api/types";
import { isWorthAdvice } from "../api/worth";
import { formatNumber } from "../base/format";
import { say, sayIf } from "../base/words";
import { Badge, type Tone } from "./basics";

interface StateText {
  readonly title: string;
  readonly tone: Tone;
}

export const kStateTones: Readonly<Record<AttemptState, Tone>> = {
  ticketed: "neutral",
  recording: "neutral",
  sealed: "neutral",
  scoring: "neutral",
  scored: "good",
  failed: "bad",
  quarantined: "bad",
};

export function stateText(state: AttemptState): StateText {
  return { title: say(`attempt_state.${state}`), tone: kStateTones[state] };
}

export function isUnderWay(state: AttemptState): boolean {
  return state === "ticketed" || state === "recording" || state === "sealed" || state === "scoring";
}

export function StateBadge({ attempt }: { readonly attempt: Pick<Attempt, "state" | "progress"> }) {
  const { title, tone } = stateText(attempt.state);
  const progress = attempt.state === "scoring" ? ` ${Math.round(attempt.progress * 100)} %` : "";
  return (
    <Badge tone={tone}>
      {title}
      {progress}
    </Badge>
  );
}

// Whether the student waits for the score. Practice (`graded` false) is never released: it shows at
// once.
export function awaitsRelease(attempt: Pick<Attempt, "state" | "released" | "as_reference">, graded: boolean): boolean {
  return attempt.state === "scored" && graded && !attempt.released && !attempt.as_reference;
}

// How much of the work was done, in percent, where what is missing cost points.
export function stoppedEarly(score: Pick<Score, "mistakes">): number | undefined {
  const missing = sizeOf(score, "not_done");
  return missing === undefined ? undefined : 100 - missing;
}

// How much of the caries was left, in percent, where that cost points.
export function cariesLeft(score: Pick<Score, "mistakes">): number | undefined {
  return sizeOf(score, "caries");
}

function sizeOf({ mistakes }: Pick<Score, "mistakes">, kind: Mistake["kind"]): number | undefined {
  return mistakes.find((mistake) => mistake.kind === kind && isWorthAdvice(mistake))?.size;
}

// What is to be known about an attempt before it is judged.
export const kFlagTones: Readonly<Record<AttemptFlag, Tone>> = {
  late: "warning",
  late_upload: "neutral",
  faster_than_time: "neutral",
  over_time: "warning",
  resumed: "neutral",
  readmitted: "neutral",
  excused: "neutral",
  returned: "neutral",
  other_hand: "bad",
  contradicted: "bad",
  shook: "warning",
  borderline_score: "warning",
  near_another: "warning",
};

// Only people who judge the attempt see how the station ran: a student cannot change that.
const kForStaff: readonly AttemptFlag[] = ["faster_than_time", "contradicted", "readmitted", "near_another"];

// The flags that are shown, in the API's order.
export function shownFlags(flags: readonly AttemptFlag[], staff: boolean): readonly AttemptFlag[] {
  return staff ? flags : flags.filter((flag) => !kForStaff.includes(flag));
}

export function flagText(flag: AttemptFlag): StateText {
  return { title: sayIf(`attempt_flag.${flag}`) ?? flag, tone: kFlagTones[flag] ?? "neutral" };
}

// What held the tool, where it was not a person at a haptic device. Undefined: nothing to say in a
// list.
export function handText(hand: Pick<Hand, "kind">): StateText | undefined {
  if (hand.kind === "program") return { title: say("hand.program"), tone: "warning" };
  return hand.kind === "pointer" ? { title: say("hand.pointer"), tone: "neutral" } : undefined;
}

interface FlagsProps {
  readonly attempt: Pick<
    Attempt,
    "state" | "released" | "as_reference" | "is_reference" | "exam" | "critical_fail" | "gap_ticks" | "flags"
  > & { readonly hand: Pick<Hand, "kind"> };
  readonly graded?: boolean; // without: nothing of its release, which a column of its own shows
  readonly staff: boolean;
  readonly appealed?: boolean; // an appeal waits for its answer
  readonly done?: number | undefined; // percent of the work, where it was stopped early
}

// What somebody skimming a list must not miss.
function flagsOf({ attempt, graded = false, staff, appealed = false, done }: FlagsProps): StateText[] {
  const hand = handText(attempt.hand);
  const when = (on: boolean, tone: Tone, title: string): StateText[] => (on ? [{ tone, title }] : []);
  return [
    ...when(appealed, "warning", say("attempt_flag.appeal")),
    ...(done === undefined
      ? []
      : when(true, "warning", say("attempt_flag.stopped_early", { percent: formatNumber(done, 1) }))),
    ...(hand === undefined ? [] : [hand]),
    ...when(attempt.exam, "neutral", say("attempt_flag.exam")),
    ...when(attempt.critical_fail === true, "bad", say("attempt_flag.critical")),
    ...when(attempt.gap_ticks > 0, "warning", say("attempt_flag.gaps")),
    ...shownFlags(attempt.flags, staff).map(flagText),
    ...when(attempt.is_reference, "good", say("attempt_flag.reference")),
    ...when(awaitsRelease(attempt, graded), "neutral", say("attempt_flag.not_released")),
  ];
}

export function Flags(props: FlagsProps) {
  return (
    <span class="flags">
      {flagsOf(props).map(({ title, tone }) => (
        <Badge key={title} tone={tone}>
          {title}
        </Badge>
      ))}
    </span>
  );
}
