import type { Attempt, AttemptFlag, AttemptState, Hand, Score } from "../api/types";
import { unreachable } from "../base/assert";
import { formatNumber } from "../base/format";
import { Badge, type Tone } from "./basics";

interface StateText {
  readonly title: string;
  readonly tone: Tone;
}

export function stateText(state: AttemptState): StateText {
  switch (state) {
    case "ticketed": return { title: "Not started", tone: "neutral" };
    case "recording": return { title: "Recording", tone: "neutral" };
    case "sealed": return { title: "Waiting to be scored", tone: "neutral" };
    case "scoring": return { title: "Being scored", tone: "neutral" };
    case "scored": return { title: "Scored", tone: "good" };
    case "failed": return { title: "Scoring failed", tone: "bad" };
    case "quarantined": return { title: "Quarantined", tone: "bad" };
    default: return unreachable(state);
  }
}

export function isUnderWay(state: AttemptState): boolean {
  return state === "ticketed" || state === "recording" || state === "sealed" || state === "scoring";
}

export function StateBadge({ attempt }: { readonly attempt: Attempt }) {
  const { title, tone } = stateText(attempt.state);
  const progress = attempt.state === "scoring" ? ` ${Math.round(attempt.progress * 100)} %` : "";
  return <Badge tone={tone}>{title}{progress}</Badge>;
}

// Whether the student waits for the score. Practice (`graded` false) is never released: it shows at once.
export function awaitsRelease(attempt: Attempt, graded: boolean): boolean {
  return attempt.state === "scored" && graded && !attempt.released && !attempt.as_reference;
}

// How much of the work was done, in percent, where that took points of every criterion.
export function stoppedEarly({ gates = [] }: Pick<Score, "gates">): number | undefined {
  const gate = gates.find(({ name, share }) => share < 1 && (name === "task_done_percent" || name === "caries_left_percent"));
  return gate === undefined ? undefined : gate.name === "task_done_percent" ? gate.value : 100 - gate.value;
}

// What is to be known about an attempt before it is judged.
export const kFlagTexts: Readonly<Record<AttemptFlag, StateText>> = {
  late: { title: "Late", tone: "warning" },
  late_upload: { title: "Uploaded late", tone: "neutral" },
  faster_than_time: { title: "Not in real time", tone: "neutral" },
  over_time: { title: "Over time", tone: "warning" },
  resumed: { title: "Resumed", tone: "neutral" },
  readmitted: { title: "Readmitted", tone: "neutral" },
  excused: { title: "Excused", tone: "neutral" },
  returned: { title: "Ticket handed back", tone: "neutral" },
  other_hand: { title: "Hand not admitted", tone: "bad" },
  contradicted: { title: "Contradicting parts", tone: "bad" },
  near_another: { title: "Motion near another's", tone: "warning" },
};

// How a station ran is for who judges the attempt: a student can do nothing about it.
const kForStaff: readonly AttemptFlag[] = ["faster_than_time", "contradicted", "readmitted", "near_another"];

// The flags that are shown, in the API's order.
export function shownFlags(flags: readonly AttemptFlag[], staff: boolean): readonly AttemptFlag[] {
  return staff ? flags : flags.filter((flag) => !kForStaff.includes(flag));
}

export function flagText(flag: AttemptFlag): StateText {
  return kFlagTexts[flag] ?? { title: flag, tone: "neutral" };
}

// What held the tool, where it was not a person at a haptic device. Undefined: nothing to say in a list.
export function handText(hand: Hand): StateText | undefined {
  if (hand.kind === "program") return { title: "Simulated hand", tone: "warning" };
  return hand.kind === "pointer" ? { title: "Mouse", tone: "neutral" } : undefined;
}

// What somebody skimming a list must not miss.
export function Flags({ attempt, graded, staff, appealed = false, done }:
    { readonly attempt: Attempt; readonly graded: boolean; readonly staff: boolean;
      readonly appealed?: boolean;              // an appeal waits for its answer
      readonly done?: number | undefined }) {   // percent of the work, where it was stopped early
  const hand = handText(attempt.hand);
  return (
    <span class="flags">
      {appealed && <Badge tone="warning">Appeal to answer</Badge>}
      {done !== undefined && <Badge tone="warning">Stopped early: {formatNumber(done, 0)} % done</Badge>}
      {hand !== undefined && <Badge tone={hand.tone}>{hand.title}</Badge>}
      {attempt.exam && <Badge tone="neutral">Exam</Badge>}
      {attempt.critical_fail === true && <Badge tone="bad">Critical</Badge>}
      {attempt.gap_ticks > 0 && <Badge tone="warning">Gaps</Badge>}
      {shownFlags(attempt.flags, staff).map((flag) => <Badge key={flag} tone={flagText(flag).tone}>{flagText(flag).title}</Badge>)}
      {attempt.is_reference && <Badge tone="good">Reference</Badge>}
      {awaitsRelease(attempt, graded) && <Badge tone="neutral">Not released</Badge>}
    </span>
  );
}
