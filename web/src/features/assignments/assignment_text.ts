import type { Assignment, Counting, Grade, HandsAllowed } from "../../api/types";
import { unreachable } from "../../base/assert";
import { formatDateTime, formatScore, plural } from "../../base/format";
import { relativeTime } from "../../base/local_time";

export type Phase = "before" | "open" | "late" | "closed";

// Where an assignment stands in time.
export function phaseOf({ opens_ms: opens, due_ms: due, late_allowed: late }: Pick<Assignment, "opens_ms" | "due_ms" | "late_allowed">, nowMs: number): Phase {
  if (nowMs < opens) return "before";
  if (due === 0 || nowMs <= due) return "open";
  return late ? "late" : "closed";
}

export function dueText({ due_ms: due }: Pick<Assignment, "due_ms">, nowMs: number): string {
  return due === 0 ? "No due date" : `${formatDateTime(due)} (${relativeTime(due, nowMs)})`;
}

// What is wrong with when it is due, for whoever sets it; undefined: nothing.
export function dueProblem({ opens_ms: opens, due_ms: due, late_allowed: late }: Pick<Assignment, "opens_ms" | "due_ms" | "late_allowed">, nowMs: number): string | undefined {
  if (due === 0) return undefined;
  if (opens > 0 && due <= opens) return "Expected a time after the opening.";
  if (due > nowMs) return undefined;
  return late ? "This time has passed: every attempt would be late." : "This time has passed: nobody could begin any more. Choose a later time.";
}

export function limitText({ attempt_limit: limit }: Pick<Assignment, "attempt_limit">): string {
  return limit === 0 ? "No limit" : plural(limit, "attempt");
}

export function exerciseTitle({ exercise }: Pick<Assignment, "exercise">): string {
  return exercise.title ?? `${exercise.name} (retired)`;
}

// What a student still may do.
export function leftText({ attempts_left: left }: { readonly attempts_left: number | null }): string {
  if (left === null) return "No limit";
  return left === 0 ? "None left" : `${plural(left, "attempt")} left`;
}

// What may hold the tool in graded work, each also what stands before it.
export const kHands: readonly { readonly value: HandsAllowed; readonly title: string }[] = [
  { value: "listed", title: "Haptic devices on the school's list" },
  { value: "haptic", title: "Any haptic device" },
  { value: "pointer", title: "Haptic devices and the mouse" },
  { value: "any", title: "Anything, also simulated hands" },
];

export function handsText({ hands }: Pick<Assignment, "hands">): string {
  return kHands.find((each) => each.value === hands)?.title ?? hands;
}

export const kCountings: readonly Counting[] = ["best", "last", "mean", "median"];

export function countingText(counting: Counting): string {
  switch (counting) {
    case "best": return "The best attempt";
    case "last": return "The last attempt";
    case "mean": return "The mean of all";
    case "median": return "The median of all";
    default: return unreachable(counting);
  }
}

// A student's result so far; what is not released is not in it.
export function resultText(grade: Grade, counting: Counting): string {
  if (grade.score === null) return "None yet";
  const waiting = grade.attempts - grade.counted;
  return `${formatScore(grade.score)}: ${countingText(counting).toLowerCase()}, ${plural(grade.counted, "attempt")} counted${waiting > 0 ? `, ${waiting} not released or not scored yet` : ""}`;
}
