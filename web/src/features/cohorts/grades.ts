import type { Attempt, CohortGrades } from "../../api/types";
import type { Cell } from "../../base/csv";

// A cohort's results as files to take along. What is one result of several attempts is the server's
// to say (schema Grade).

export interface CsvTable {
  readonly header: readonly string[];
  readonly rows: ReadonlyArray<readonly Cell[]>;
}

// For each assignment the result, and over how many attempts it is.
export function gradesTable({ assignments, students }: CohortGrades): CsvTable {
  const titles = assignments.map(({ exercise }) => (exercise.title !== "" ? exercise.title : exercise.name));
  return {
    header: [
      "person",
      "login",
      "display_name",
      ...titles,
      "assignments_done",
      ...assignments.flatMap(({ counting }, i) => [
        `${titles[i]} (${counting} of attempts)`,
        `${titles[i]} (released)`,
      ]),
    ],
    rows: students.map(({ person, grades }) => [
      person.id,
      person.login,
      person.display_name,
      ...grades.map((grade) => rounded(grade.score)),
      grades.filter((grade) => grade.score !== null).length,
      ...grades.flatMap((grade) => [grade.counted, grade.released]),
    ]),
  };
}

export function attemptsTable(attempts: readonly Attempt[]): CsvTable {
  return {
    header: [
      "display_name",
      "exercise",
      "begun_utc",
      "finished_utc",
      "state",
      "score",
      "computed_score",
      "critical_fail",
      "released",
      "exam",
      "flags",
      "station",
      "attempt",
    ],
    rows: attempts.map((attempt) => [
      attempt.person.display_name,
      attempt.exercise.title,
      isoOf(attempt.ticketed_ms),
      isoOf(attempt.sealed_ms),
      attempt.state,
      rounded(attempt.score),
      rounded(attempt.computed_score),
      attempt.critical_fail,
      attempt.released,
      attempt.exam,
      attempt.flags.join(" "),
      attempt.station.name,
      attempt.id,
    ]),
  };
}

// Rounded as on the page.
function rounded(score: number | null): number | null {
  return score === null ? null : Math.round(score * 10) / 10;
}

function isoOf(unixMs: number): string | null {
  return unixMs > 0 ? new Date(unixMs).toISOString() : null;
}
