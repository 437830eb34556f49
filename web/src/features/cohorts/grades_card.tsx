import { exerciseTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { addressOf } from "../../api/http";
import type { Cohort, CohortGrades, Grade } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { fileName } from "../../base/download";
import { formatScore } from "../../base/format";
import { namesIn } from "../../base/names";
import { say } from "../../base/words";
import { Card, Empty, TableFrame, Waits } from "../../widgets/basics";
import { Rows } from "../../widgets/rows";
import { rowCount } from "../../widgets/table";

// Everything that was done under a cohort's assignments: on the screen, and as files to take along.
export function GradesCard({ client, cohort }: { readonly client: Client; readonly cohort: Cohort }) {
  // Who is in it decides what is shown: read again with every change of the cohort.
  const { loaded, reload } = useRequest(
    `${cohort.id} ${cohort.members.map((member) => member.id).join(" ")}`,
    (signal) => client.get("/cohorts/{id}/grades", { id: cohort.id, signal }),
  );
  return (
    <Card title={say("grades.title")}>
      <Waits loaded={loaded} reload={reload} what={say("loading.grades")} failed={say("grades.failed")} />
      {loaded.state === "ready" && <Grades cohort={cohort} grades={loaded.value} />}
    </Card>
  );
}

function Grades({
  cohort,
  grades: { assignments, students },
}: {
  readonly cohort: Cohort;
  readonly grades: CohortGrades;
}) {
  if (assignments.length === 0) return <Empty>{say("grades.none")}</Empty>;
  const name = namesIn(students.map(({ person }) => person));
  return (
    <>
      <TableFrame label={say("grades.of", { name: cohort.name })}>
        <table class="grades dense" {...rowCount(students.length)}>
          <thead>
            <tr>
              <th scope="col">{say("common.student")}</th>
              {assignments.map(({ id, exercise, counting }) => (
                <th key={id} scope="col" class="wrap number">
                  <a href={`/assignments/${id}`}>{exerciseTitle(exercise)}</a>
                  <span class="sub">{say(`grades_by.${counting}`)}</span>
                </th>
              ))}
            </tr>
          </thead>
          <Rows
            keys={students.map(({ person }) => person.id)}
            row={(index, place) => {
              const { person, grades } = students[index]!;
              return (
                <tr {...place}>
                  <th scope="row">{name(person)}</th>
                  {grades.map((grade, i) => (
                    <td key={assignments[i]!.id} class="number">
                      <GradeCell grade={grade} />
                    </td>
                  ))}
                </tr>
              );
            }}
          />
          <tfoot>
            {kFigures.map((name) => (
              <tr key={name}>
                <th scope="row">{say(`grades.${name}`)}</th>
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
        <a
          class="button"
          href={addressOf("/cohorts/{id}/grades.csv", { id: cohort.id })}
          download={`${fileName(cohort.name, "grades")}.csv`}
        >
          {say("grades.save")}
        </a>
        <a
          class="button"
          href={addressOf("/cohorts/{id}/attempts.csv", { id: cohort.id })}
          download={`${fileName(cohort.name, "attempts")}.csv`}
        >
          {say("grades.save_attempts")}
        </a>
      </div>
    </>
  );
}

const kFigures = ["mean", "median", "lowest", "highest"] as const;

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
