import type { Attempt, AttemptFlag, AttemptState, Hand } from "../api/types";
import { unreachable } from "../base/assert";
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

// What is to be known about an attempt before it is judged.
export const kFlagTexts: Readonly<Record<AttemptFlag, StateText>> = {
  late: { title: "Late", tone: "warning" },
  late_upload: { title: "Uploaded late", tone: "neutral" },
  faster_than_time: { title: "Faster than real time", tone: "bad" },
  over_time: { title: "Over time", tone: "warning" },
  resumed: { title: "Resumed", tone: "neutral" },
  readmitted: { title: "Readmitted", tone: "neutral" },
  excused: { title: "Excused", tone: "neutral" },
  returned: { title: "Ticket handed back", tone: "neutral" },
  other_hand: { title: "Hand not admitted", tone: "bad" },
  contradicted: { title: "Contradicting parts", tone: "bad" },
};

export function flagText(flag: AttemptFlag): StateText {
  return kFlagTexts[flag] ?? { title: flag, tone: "neutral" };
}

// What held the tool, where it was not a person at a haptic device. Undefined: nothing to say in a list.
export function handText(hand: Hand): StateText | undefined {
  if (hand.kind === "program") return { title: "Simulated hand", tone: "warning" };
  return hand.kind === "pointer" ? { title: "Mouse", tone: "neutral" } : undefined;
}

// What somebody skimming a list must not miss.
export function Flags({ attempt, graded }: { readonly attempt: Attempt; readonly graded: boolean }) {
  const hand = handText(attempt.hand);
  return (
    <span class="flags">
      {hand !== undefined && <Badge tone={hand.tone}>{hand.title}</Badge>}
      {attempt.exam && <Badge tone="neutral">Exam</Badge>}
      {attempt.critical_fail === true && <Badge tone="bad">Critical</Badge>}
      {attempt.gap_ticks > 0 && <Badge tone="warning">Gaps</Badge>}
      {attempt.flags.map((flag) => <Badge key={flag} tone={flagText(flag).tone}>{flagText(flag).title}</Badge>)}
      {attempt.is_reference && <Badge tone="good">Reference</Badge>}
      {awaitsRelease(attempt, graded) && <Badge tone="neutral">Not released</Badge>}
    </span>
  );
}
