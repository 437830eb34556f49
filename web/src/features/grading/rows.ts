import type { Attempt, Score } from "../../api/types";
import { compareNames, nameHas } from "../../base/names";

// What the table of attempts to be graded shows, and in which order.

export interface GradingRow {
  readonly attempt: Attempt;
  readonly score: Score | undefined; // undefined: not scored, or not read yet
}

export interface CriterionColumn {
  readonly name: string;
  readonly title: string;
}

// By what the table is sorted: a column's name, or a criterion's.
export interface Order {
  readonly by: "name" | "when" | "score" | string;
  readonly down: boolean; // the largest first
}

// Every criterion that some attempt was judged by, in the rubric's order.
export function criteriaOf(rows: readonly GradingRow[]): CriterionColumn[] {
  const found = new Map<string, CriterionColumn>();
  for (const { score } of rows) {
    for (const { name, title } of score?.criteria ?? []) if (!found.has(name)) found.set(name, { name, title });
  }
  return [...found.values()];
}

// Points lost, all of them where it was not made; undefined where they were nobody's to lose.
export function lostOn({ score }: GradingRow, criterion: string): number | undefined {
  const found = score?.criteria.find(({ name }) => name === criterion);
  return found === undefined || found.max_points === 0 ? undefined : Math.max(0, found.max_points - found.points);
}

// What has no value comes last, whichever way; equal ones by name, so that the order does not jump.
export function sorted(rows: readonly GradingRow[], { by, down }: Order): GradingRow[] {
  const value = (row: GradingRow): number | string | undefined => {
    if (by === "name") return row.attempt.person.display_name;
    if (by === "when") return row.attempt.ticketed_ms;
    return by === "score" ? (row.attempt.score ?? undefined) : lostOn(row, by);
  };
  return [...rows].sort((one, other) => {
    const [a, b] = [value(one), value(other)];
    if (a === undefined || b === undefined) return a === b ? byName(one, other) : a === undefined ? 1 : -1;
    const order = typeof a === "string" ? compareNames(a, String(b)) : a - Number(b);
    return order === 0 ? byName(one, other) : down ? -order : order;
  });
}

export function named(rows: readonly GradingRow[], text: string): GradingRow[] {
  return rows.filter(({ attempt }) => nameHas(attempt.person.display_name, text));
}

function byName(a: GradingRow, b: GradingRow): number {
  return (
    compareNames(a.attempt.person.display_name, b.attempt.person.display_name) ||
    a.attempt.ticketed_ms - b.attempt.ticketed_ms
  );
}
