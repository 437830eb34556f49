import type { Grading } from "../../api/types";
import { compareNames, nameHas } from "../../base/names";

// What the table of attempts to be graded shows, and in which order.

export type GradedAttempt = Omit<Grading["attempts"][number], "exercise"> & {
  readonly exercise: Grading["exercises"][number];
};

export type Criterion = Pick<Grading["criteria"][number], "name" | "title">;

// By what the table is sorted: a column's name, or a criterion's.
export interface Order {
  readonly by: "name" | "when" | "score" | string;
  readonly down: boolean; // the largest first
}

export function attemptsOf({ attempts, exercises }: Grading): GradedAttempt[] {
  return attempts.flatMap((attempt) => {
    const exercise = exercises[attempt.exercise];
    return exercise === undefined ? [] : [{ ...attempt, exercise }];
  });
}

// Points lost on the criterion in this place; undefined where they were nobody's to lose.
export function lostOn({ lost }: Pick<GradedAttempt, "lost">, place: number): number | undefined {
  return lost?.[place] ?? undefined;
}

// What has no value comes last, whichever way; equal ones by name, so that the order does not jump.
export function sorted(
  attempts: readonly GradedAttempt[],
  { by, down }: Order,
  criteria: readonly Criterion[],
): GradedAttempt[] {
  const place = criteria.findIndex(({ name }) => name === by);
  const value = (attempt: GradedAttempt): number | undefined =>
    by === "when" ? attempt.ticketed_ms : by === "score" ? (attempt.score ?? undefined) : lostOn(attempt, place);
  const byValue = (one: GradedAttempt, other: GradedAttempt): number => {
    const [a, b] = [value(one), value(other)];
    if (a === undefined || b === undefined) return a === b ? 0 : a === undefined ? 1 : -1;
    return down ? b - a : a - b;
  };
  const named = [...attempts].sort((one, other) => byName(one, other) * (by === "name" && down ? -1 : 1));
  return by === "name" ? named : named.sort(byValue);
}

export function named(attempts: readonly GradedAttempt[], text: string): readonly GradedAttempt[] {
  return text.trim() === "" ? attempts : attempts.filter(({ person }) => nameHas(person.display_name, text));
}

function byName(a: GradedAttempt, b: GradedAttempt): number {
  return compareNames(a.person.display_name, b.person.display_name) || a.ticketed_ms - b.ticketed_ms;
}
