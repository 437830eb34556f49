import type { Client } from "../../api/client";
import type { AssignmentInsight, Spread } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { csvText } from "../../base/csv";
import { downloadText, fileName } from "../../base/download";
import { formatDateTime, formatDuration, formatPoints, formatQuantity, formatScore, plural } from "../../base/format";
import { Badge, Card, Empty, ErrorNotice, Loading, Notice } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import { Tenths } from "../../widgets/tenths";
import { commonestText, insightTable, outlierText } from "./insight";

interface Props {
  readonly client: Client;
  readonly id: string;
  readonly title: string;                       // of the exercise
}

// How the class did: who has not begun, what was lost where, what stands out.
export function InsightCard({ client, id, title }: Props) {
  const { loaded, reload } = useRequest(`insight ${id}`, (signal) => client.teaching.insight(id, signal));
  const save = (insight: AssignmentInsight) => {
    const { header, rows } = insightTable(insight);
    downloadText(`${fileName(title, "class")}.csv`, "text/csv", csvText(header, rows));
  };
  const aside = loaded.state === "ready" && loaded.value.students.length > 0
    ? <button type="button" class="button small" onClick={() => save(loaded.value)}>Save as CSV</button> : undefined;
  return (
    <Card title="The class" aside={aside} className="insight">
      {loaded.state === "loading" && <Loading what="the class" />}
      {loaded.state === "failed" && <ErrorNotice title="The class could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && <Insight insight={loaded.value} />}
    </Card>
  );
}

function Insight({ insight }: { readonly insight: AssignmentInsight }) {
  const { summary, criteria, students, staff, gates } = insight;
  return (
    <>
      {students.length === 0 ? <Empty>No student is in this class yet.</Empty> : <Figures summary={summary} />}
      {insight.left_out > 0 && <Notice tone="warning"><p>{plural(insight.left_out, "student")} more than can be shown at once: choose one cohort.</p></Notice>}
      {insight.unread > 0 && <Notice tone="warning"><p>The scores of {plural(insight.unread, "student")} could not be read in full. Score these attempts again.</p></Notice>}
      {students.length > 0 && <p class="insight-say">{commonestText(insight)}</p>}
      {gates.map(({ name, title, taken }) => <p key={name} class="insight-say">{title}: took points from {plural(taken, "student")}.</p>)}
      {summary.scored > 0 && criteria.length > 0 && <Criteria insight={insight} />}
      <div class="columns">
        <Waiting students={students} />
        <Outliers insight={insight} />
        {staff.length > 0 && <Staff staff={staff} />}
      </div>
    </>
  );
}

function Figures({ summary }: { readonly summary: AssignmentInsight["summary"] }) {
  return (
    <dl class="facts">
      <div><dt>Not started</dt><dd>{summary.not_started} of {summary.students}</dd></div>
      <div><dt>Begun, not scored</dt><dd>{summary.waiting}</dd></div>
      <div><dt>Scored</dt><dd>{summary.scored}{summary.failed > 0 && <> <Badge tone="bad">{plural(summary.failed, "critical failure")}</Badge></>}</dd></div>
      {summary.scores !== null && <div><dt>Score, median and middle half</dt><dd>{middle(summary.scores, formatScore)}</dd></div>}
      {summary.times_s !== null && <div><dt>Time, median and middle half</dt><dd>{middle(summary.times_s, formatDuration)}</dd></div>}
      {summary.scored > 0 && <div><dt>Scores, 0 to 100</dt><dd><Tenths counts={summary.score_tenths} what="scores" /></dd></div>}
    </dl>
  );
}

function middle({ lower, median, upper }: Spread, form: (value: number) => string): string {
  return `${form(median)} (${form(lower)} to ${form(upper)})`;
}

function Criteria({ insight: { criteria, commonest } }: { readonly insight: AssignmentInsight }) {
  return (
    <DataTable label="By criterion" items={criteria} rowKey={(item) => item.name} dense columns={[
      { title: "Criterion", cell: (item) => <>{item.title}{item.name === commonest && <> <Badge tone="warning">commonest error</Badge></>}</> },
      { title: "Points, mean", number: true, cell: (item) => item.judged === 0 ? "–" : `${formatPoints(item.mean_points)} of ${formatPoints(item.max_points)}` },
      { title: "Share of the points earned", cell: (item) => item.judged > 0 && <Tenths counts={item.earned_tenths} what={`shares of the points for ${item.title}`} /> },
      { title: "Lost half or more", number: true, cell: (item) => item.judged === 0 ? <span class="hint">not judged</span> : `${item.half_lost} of ${item.judged}` },
      { title: "Measured, median and middle half", cell: (item) => item.values === null ? "–" : middle(item.values, (value) => formatQuantity(value, item.unit)) },
    ]} />
  );
}

function Waiting({ students }: { readonly students: AssignmentInsight["students"] }) {
  const names = (state: string) => students.filter((student) => student.state === state).map(({ person }) => person);
  const none = names("not_started");
  const begun = names("waiting");
  if (students.length === 0) return null;
  return (
    <section aria-label="Not started">
      <h3>Not started ({none.length})</h3>
      {none.length === 0 ? <p class="hint">Everybody has begun.</p> : <ul class="name-list">{none.map((person) => <li key={person.id}>{person.display_name}</li>)}</ul>}
      {begun.length > 0 && <><h3>Begun, not scored ({begun.length})</h3><ul class="name-list">{begun.map((person) => <li key={person.id}>{person.display_name}</li>)}</ul></>}
    </section>
  );
}

function Outliers({ insight: { outliers, students, criteria, summary } }: { readonly insight: AssignmentInsight }) {
  if (summary.scored === 0) return null;
  const byPerson = new Map(students.map((student) => [student.person.id, student]));
  return (
    <section aria-label="Far from the class">
      <h3>Far from the class ({outliers.length})</h3>
      {outliers.length === 0 ? <p class="hint">Nothing stands out{summary.scored < 8 ? "; with fewer than 8 students nothing is told" : ""}.</p> : (
        <ul class="say-list">
          {outliers.map((outlier) => {
            const student = byPerson.get(outlier.person_id);
            const name = student?.person.display_name ?? "";
            return <li key={`${outlier.person_id} ${outlier.what}`}>{student?.attempt_id == null ? name : <a href={`/attempts/${student.attempt_id}`}>{name}</a>}: {outlierText(outlier, criteria)}</li>;
          })}
        </ul>
      )}
    </section>
  );
}

// Apart from the class: who teaches it is in none of its figures.
function Staff({ staff }: { readonly staff: AssignmentInsight["staff"] }) {
  return (
    <section aria-label="Those who teach">
      <h3>Those who teach, not counted above</h3>
      <DataTable label="Attempts of those who teach" items={staff} rowKey={(row) => row.attempt_id} dense columns={[
        { title: "Name", cell: (row) => <a href={`/attempts/${row.attempt_id}`}>{row.person.display_name}</a> },
        { title: "Begun", cell: (row) => formatDateTime(row.ticketed_ms) },
        { title: "Time", number: true, cell: (row) => formatDuration(row.time_s) },
        { title: "Score", number: true, cell: (row) => formatScore(row.score) },
        { title: "Kind", cell: (row) => row.as_reference ? <Badge tone="neutral">Reference cut</Badge> : "Own try" },
      ]} />
    </section>
  );
}
