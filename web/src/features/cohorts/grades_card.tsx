import { useMemo } from "preact/hooks";
import type { Client } from "../../api/client";
import { readAll } from "../../api/read_all";
import type { Assignment, Attempt, Cohort } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { csvText } from "../../base/csv";
import { downloadText, fileName } from "../../base/download";
import { formatScore, plural } from "../../base/format";
import { ok } from "../../base/result";
import { Card, Empty, ErrorNotice, Loading, TableFrame } from "../../widgets/basics";
import { attemptsTable, type CsvTable, type Grade, gradeRows, gradesTable } from "./grades";

const kPageSize = 200;

interface Book {
  readonly assignments: readonly Assignment[];
  readonly attempts: readonly Attempt[];
}

// Everything that was done under a cohort's assignments: on the screen, and as files to take along.
export function GradesCard({ client, cohort }: { readonly client: Client; readonly cohort: Cohort }) {
  const { loaded, reload } = useRequest(cohort.id, async (signal) => {
    const assignments = await client.teaching.assignments({ cohort: cohort.id }, signal);
    if (!assignments.ok) return assignments;
    const attempts = await readAll((cursor) => client.attempts({ cohort: cohort.id, cursor, limit: kPageSize }, signal));
    return attempts.ok ? ok({ assignments: assignments.value, attempts: attempts.value }) : attempts;
  });
  return (
    <Card title="Grades">
      {loaded.state === "loading" && <Loading what="the grades" />}
      {loaded.state === "failed" && <ErrorNotice title="The grades could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && <Grades cohort={cohort} book={loaded.value} />}
    </Card>
  );
}

function Grades({ cohort, book }: { readonly cohort: Cohort; readonly book: Book }) {
  const { assignments, attempts } = book;
  const rows = useMemo(() => gradeRows(cohort.members, assignments, attempts), [cohort, assignments, attempts]);
  const save = (name: string, table: CsvTable) => downloadText(`${fileName(cohort.name, name)}.csv`, "text/csv", csvText(table.header, table.rows));
  if (assignments.length === 0) return <Empty>Nothing is assigned to this cohort yet.</Empty>;
  return (
    <>
      <TableFrame label={`Grades of ${cohort.name}`}>
        <table class="grades dense">
          <thead>
            <tr><th scope="col">Student</th>{assignments.map((item) => <th key={item.id} scope="col" class="wrap number"><a href={`/assignments/${item.id}`}>{item.exercise.title ?? item.exercise.name}</a></th>)}</tr>
          </thead>
          <tbody>
            {rows.map((row) => (
              <tr key={row.member.id}>
                <th scope="row">{row.member.display_name}</th>
                {row.grades.map((grade, i) => <td key={assignments[i]!.id} class="number"><GradeCell grade={grade} /></td>)}
              </tr>
            ))}
          </tbody>
        </table>
      </TableFrame>
      <p class="hint">The best scored attempt counts. A star: not released. Practice shows to the student without a release.</p>
      <div class="button-row">
        <button type="button" class="button" onClick={() => save("grades", gradesTable(rows, assignments))}>Save grades as CSV</button>
        <button type="button" class="button" onClick={() => save("attempts", attemptsTable(attempts))}>Save all {plural(attempts.length, "attempt")} as CSV</button>
      </div>
    </>
  );
}

function GradeCell({ grade }: { readonly grade: Grade }) {
  if (grade.best === undefined) return <span class="hint">{grade.attempts === 0 ? "–" : "not scored"}</span>;
  return <a href={`/attempts/${grade.best.id}`}>{formatScore(grade.best.score)}{!grade.best.released && <span title="Not released">*<span class="hidden"> not released</span></span>}</a>;
}
