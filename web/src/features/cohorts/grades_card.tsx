import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { readAll } from "../../api/http";
import type { Attempt, Cohort, CohortGrades, Grade } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { csvText } from "../../base/csv";
import { downloadFile, fileName } from "../../base/download";
import { formatScore } from "../../base/format";
import { ok } from "../../base/result";
import { say } from "../../base/words";
import { Card, Empty, ErrorNotice, Loading, TableFrame } from "../../widgets/basics";
import { attemptsTable, type CsvTable, gradesTable } from "./grades";

const kPageSize = 200;

interface Book {
  readonly grades: CohortGrades;
  readonly attempts: readonly Attempt[];
}

// Everything that was done under a cohort's assignments: on the screen, and as files to take along.
export function GradesCard({ client, cohort }: { readonly client: Client; readonly cohort: Cohort }) {
  // Who is in it decides what is shown: read again with every change of the cohort.
  const { loaded, reload } = useRequest(
    `${cohort.id} ${cohort.members.map((member) => member.id).join(" ")}`,
    async (signal) => {
      const grades = await client.teaching.grades(cohort.id, signal);
      if (!grades.ok) return grades;
      const attempts = await readAll((cursor) =>
        client.attempts({ cohort: cohort.id, cursor, limit: kPageSize }, signal),
      );
      return attempts.ok ? ok({ grades: grades.value, attempts: attempts.value }) : attempts;
    },
  );
  return (
    <Card title={say("grades.title")}>
      {loaded.state === "loading" && <Loading what={say("loading.grades")} />}
      {loaded.state === "failed" && (
        <ErrorNotice title={say("grades.failed")} message={loaded.error.message} onRetry={reload} />
      )}
      {loaded.state === "ready" && <Grades cohort={cohort} book={loaded.value} />}
    </Card>
  );
}

function Grades({ cohort, book }: { readonly cohort: Cohort; readonly book: Book }) {
  const {
    grades: { assignments, students },
    attempts,
  } = book;
  const save = (name: string, table: CsvTable) =>
    downloadFile(`${fileName(cohort.name, name)}.csv`, "text/csv", csvText(table.header, table.rows));
  if (assignments.length === 0) return <Empty>{say("grades.none")}</Empty>;
  return (
    <>
      <TableFrame label={say("grades.of", { name: cohort.name })}>
        <table class="grades dense">
          <thead>
            <tr>
              <th scope="col">{say("common.student")}</th>
              {assignments.map(({ id, exercise, counting }) => (
                <th key={id} scope="col" class="wrap number">
                  <a href={`/assignments/${id}`}>{wordedTitle(exercise.title) || exercise.name}</a>
                  <span class="sub">{say(`grades_by.${counting}`)}</span>
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {students.map(({ person, grades }) => (
              <tr key={person.id}>
                <th scope="row">{person.display_name}</th>
                {grades.map((grade, i) => (
                  <td key={assignments[i]!.id} class="number">
                    <GradeCell grade={grade} />
                  </td>
                ))}
              </tr>
            ))}
          </tbody>
          <tfoot>
            {kFigures.map(({ name, title }) => (
              <tr key={name}>
                <th scope="row">{title}</th>
                {assignments.map(({ id, summary }) => (
                  <td key={id} class="number">
                    {formatScore(summary[name])}
                  </td>
                ))}
              </tr>
            ))}
            <tr>
              <th scope="row">{say("grades.with_result")}</th>
              {assignments.map(({ id, summary }) => (
                <td key={id} class="number">
                  {say("count.of", { part: String(summary.graded), whole: String(summary.students) })}
                </td>
              ))}
            </tr>
            <tr>
              <th scope="row">{say("attempt_state.ticketed")}</th>
              {assignments.map(({ id }, i) => (
                <td key={id} class="number">
                  {students.filter(({ grades }) => grades[i]?.attempts === 0).length}
                </td>
              ))}
            </tr>
          </tfoot>
        </table>
      </TableFrame>
      <p class="hint">{say("grades.hint")}</p>
      <div class="button-row">
        <button type="button" class="button" onClick={() => save("grades", gradesTable(book.grades))}>
          {say("grades.save")}
        </button>
        <button type="button" class="button" onClick={() => save("attempts", attemptsTable(attempts))}>
          {say("grades.save_attempts", { count: attempts.length })}
        </button>
      </div>
    </>
  );
}

const kFigures = [
  {
    name: "mean",
    get title() {
      return say("grades.mean");
    },
  },
  {
    name: "median",
    get title() {
      return say("grades.median");
    },
  },
  {
    name: "lowest",
    get title() {
      return say("grades.lowest");
    },
  },
  {
    name: "highest",
    get title() {
      return say("grades.highest");
    },
  },
] as const;

function GradeCell({ grade }: { readonly grade: Grade }) {
  if (grade.score === null) return <span class="hint">{grade.attempts === 0 ? "–" : say("grades.not_scored")}</span>;
  const text = (
    <>
      {formatScore(grade.score)} ({grade.counted})
      {!grade.released && (
        <span title={say("attempt_flag.not_released")}>
          *<span class="hidden"> {say("grades.not_released")}</span>
        </span>
      )}
    </>
  );
  return grade.attempt_id === null ? text : <a href={`/attempts/${grade.attempt_id}`}>{text}</a>;
}
