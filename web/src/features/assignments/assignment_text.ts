import { exerciseTitle as titleOf } from "../../api/builtin_words";
import type { Assignment, Counting, Grade, HandsAllowed, OutlineShown } from "../../api/types";
import { formatDateTime, formatScore } from "../../base/format";
import { relativeTime } from "../../base/local_time";
import { say } from "../../base/words";

export type Phase = "before" | "open" | "late" | "closed";

// The phase of an assignment: before, open or over.
export function phaseOf(
  { opens_ms: opens, due_ms: due, late_allowed: late }: Pick<Assignment, "opens_ms" | "due_ms" | "late_allowed">,
  nowMs: number,
): Phase {
  if (nowMs < opens) return "before";
  if (due === 0 || nowMs <= due) return "open";
  return late ? "late" : "closed";
}

// Terms under which no attempt begins from now on.
export function endedTerms<T extends Pick<Assignment, "due_ms" | "late_allowed">>(terms: T, nowMs: number): T {
  return { ...terms, due_ms: nowMs, late_allowed: false };
}

export function dueText({ due_ms: due }: Pick<Assignment, "due_ms">, nowMs: number): string {
  return due === 0 ? say("assignments.no_due") : `${formatDateTime(due)} (${relativeTime(due, nowMs)})`;
}

// What is wrong with when it is due, for whoever sets it; undefined: nothing.
export function dueProblem(
  { opens_ms: opens, due_ms: due, late_allowed: late }: Pick<Assignment, "opens_ms" | "due_ms" | "late_allowed">,
  nowMs: number,
): string | undefined {
  if (due === 0) return undefined;
  if (opens > 0 && due <= opens) return say("assignments.after_opening");
  if (due > nowMs) return undefined;
  return late ? say("assignments.past_late") : say("assignments.past_closed");
}

export function limitText({ attempt_limit: limit }: Pick<Assignment, "attempt_limit">): string {
  return limit === 0 ? say("assignments.no_limit") : say("count.attempts", { count: limit });
}

export function exerciseTitle({ exercise }: Pick<Assignment, "exercise">): string {
  const title = titleOf(exercise);
  return exercise.retired || exercise.title === null ? say("assignments.retired", { name: title }) : title;
}

// What a student still may do.
export function leftText({ attempts_left: left }: { readonly attempts_left: number | null }): string {
  if (left === null) return say("assignments.no_limit");
  return left === 0 ? say("assignments.none_left") : say("assignments.left", { count: left });
}

// What may hold the tool in graded work, each also what stands before it.
export const kHands: readonly HandsAllowed[] = ["listed", "haptic", "pointer", "any"];

export function handsText({ hands }: Pick<Assignment, "hands">): string {
  return say(`hands.${hands}`);
}

// In which work the chair shows the target's outline on the tooth.
export const kOutlines: readonly OutlineShown[] = ["practice", "always", "never"];

export function outlineText({ outline }: Pick<Assignment, "outline">): string {
  return say(`outline.${outline}`);
}

export const kCountings: readonly Counting[] = ["best", "last", "mean", "median"];

export function countingText(counting: Counting): string {
  return say(`counting.${counting}`);
}

// A student's result so far; what is not released is not in it.
export function resultText(grade: Grade, counting: Counting): string {
  if (grade.regrading) return say("assignments.regrading");
  if (grade.score === null) return say("assignments.no_result");
  const waiting = grade.attempts - grade.counted;
  return waiting > 0
    ? say(`result_waiting.${counting}`, { score: formatScore(grade.score), count: grade.counted, waiting })
    : say(`result_of.${counting}`, { score: formatScore(grade.score), count: grade.counted });
}
