import type { Assignment, Attempt, CohortMember } from "../../api/types";
import type { Cell } from "../../base/csv";

// A cohort's grades: a row for each student, a column for each assignment. What counts is the best
// scored attempt under an assignment; a set score counts instead of the computed one (`score` says
// what counts already).

export interface Grade {
  readonly attempts: number;
  readonly best: Attempt | undefined;           // undefined: nothing scored yet
}

export interface GradeRow {
  readonly member: CohortMember;
  readonly grades: readonly Grade[];            // as the assignments are ordered
}

export function gradeRows(members: readonly CohortMember[], assignments: readonly Assignment[], attempts: readonly Attempt[]): GradeRow[] {
  const byKey = new Map<string, Attempt[]>();
  for (const attempt of attempts) {
    const key = `${attempt.person.id} ${attempt.assignment_id}`;
    byKey.set(key, [...(byKey.get(key) ?? []), attempt]);
  }
  return members.filter((member) => member.role === "student")
    .sort((a, b) => a.display_name.localeCompare(b.display_name, undefined, { numeric: true }))
    .map((member) => ({
      member,
      grades: assignments.map((assignment) => gradeOf(byKey.get(`${member.id} ${assignment.id}`) ?? [])),
    }));
}

function gradeOf(attempts: readonly Attempt[]): Grade {
  const counting = attempts.filter((attempt) => !attempt.flags.includes("excused") && !attempt.flags.includes("returned"));
  const best = counting.filter((attempt) => attempt.score !== null).sort((a, b) => (b.score ?? 0) - (a.score ?? 0))[0];
  return { attempts: counting.length, best };
}

export interface CsvTable {
  readonly header: readonly string[];
  readonly rows: ReadonlyArray<readonly Cell[]>;
}

export function gradesTable(rows: readonly GradeRow[], assignments: readonly Assignment[]): CsvTable {
  return {
    header: ["person", "login", "display_name", ...assignments.map((assignment) => assignment.exercise.title ?? assignment.exercise.name), "assignments_done"],
    rows: rows.map(({ member, grades }) => [
      member.id, member.login, member.display_name, ...grades.map((grade) => rounded(grade.best?.score ?? null)), grades.filter((grade) => grade.best !== undefined).length,
    ]),
  };
}

export function attemptsTable(attempts: readonly Attempt[]): CsvTable {
  return {
    header: ["display_name", "exercise", "begun_utc", "finished_utc", "state", "score", "computed_score", "critical_fail", "released", "exam", "flags", "station", "attempt"],
    rows: attempts.map((attempt) => [
      attempt.person.display_name, attempt.exercise.title, isoOf(attempt.ticketed_ms), isoOf(attempt.sealed_ms), attempt.state,
      rounded(attempt.score), rounded(attempt.computed_score), attempt.critical_fail, attempt.released, attempt.exam, attempt.flags.join(" "), attempt.station.name, attempt.id,
    ]),
  };
}

// As it is shown.
function rounded(score: number | null): number | null {
  return score === null ? null : Math.round(score * 10) / 10;
}

function isoOf(unixMs: number): string | null {
  return unixMs > 0 ? new Date(unixMs).toISOString() : null;
}
