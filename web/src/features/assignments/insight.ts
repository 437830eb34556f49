import type { AssignmentInsight } from "../../api/types";
import { criterionTitle, measuredText, mistakeText } from "../../api/worded";
import type { Cell } from "../../base/csv";
import { formatDuration, formatScore } from "../../base/format";
import { say } from "../../base/words";

// What is said of a class, and its table to take along. The figures are the server's (schema
// AssignmentInsight).

type Outlier = AssignmentInsight["outliers"][number];

export type ClassMistake = AssignmentInsight["mistakes"][number];

// Which mistake most students made, in a sentence.
export function commonestText({ commonest, mistakes, summary }: AssignmentInsight): string {
  const found = commonest === null ? undefined : mistakes[commonest];
  if (found !== undefined)
    return say("insight.commonest", {
      mistake: mistakeText(found),
      made: found.students,
      count: summary.scored,
    });
  return summary.scored === 0 ? say("insight.nothing_scored") : say("insight.none_lost");
}

const kTime = "time_s",
  kTimeOfAll = "time_all_attempts_s";

// A student with one attempt has one time, which appears once.
export function outliersOf({ outliers, students }: AssignmentInsight): Outlier[] {
  return outliers.filter(
    ({ person_id: id, what }) =>
      what !== kTime ||
      (students.find(({ person }) => person.id === id)?.attempts ?? 0) > 1 ||
      !outliers.some((other) => other.person_id === id && other.what === kTimeOfAll),
  );
}

// What a student has that the class has not.
export function outlierText(outlier: Outlier, insight: AssignmentInsight): string {
  const { what, value, median } = outlier;
  const { criteria } = insight;
  if (what === "score") return say("insight.outlier_score", { value: formatScore(value), median: formatScore(median) });
  if (what === kTimeOfAll)
    return say("insight.outlier_time", { value: formatDuration(value), median: formatDuration(median) });
  const found = criteria.find(({ name }) => name === what);
  const unit = found?.unit ?? "";
  return say("insight.outlier", {
    title: found === undefined ? what : criterionTitle(found),
    value: measuredText(what, value, unit),
    median: measuredText(what, median, unit),
  });
}

// A row for each student; points lost by criterion, empty where there were none to lose.
export function insightTable({ criteria, students }: AssignmentInsight): {
  readonly header: readonly string[];
  readonly rows: ReadonlyArray<readonly Cell[]>;
} {
  return {
    header: [
      "login",
      "display_name",
      "state",
      "attempts",
      "score",
      "released",
      "failed_critically",
      "time_s_all_attempts",
      ...criteria.map((criterion) => `${criterionTitle(criterion)} (points lost)`),
    ],
    rows: students.map(({ person, state, attempts, score, released, failed, time_s: time, lost }) => [
      person.login,
      person.display_name,
      state,
      attempts,
      rounded(score),
      released,
      failed,
      rounded(time),
      ...lost.map(rounded),
    ]),
  };
}

// Rounded as on the page.
function rounded(value: number | null): number | null {
  return value === null ? null : Math.round(value * 10) / 10;
}
