import type { Client } from "../../api/client";
import type { AssignmentInsight, Spread } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { wordedInsight } from "../../api/worded";
import { csvText } from "../../base/csv";
import { downloadFile, fileName } from "../../base/download";
import { formatDateTime, formatDuration, formatPoints, formatQuantity, formatScore } from "../../base/format";
import { ok } from "../../base/result";
import { say } from "../../base/words";
import { Badge, Card, Empty, ErrorNotice, Loading, Notice } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import { Tenths } from "../../widgets/tenths";
import { commonestText, insightTable, outliersOf, outlierText } from "./insight";

const kMostSetAside = 200;

interface Props {
  readonly client: Client;
  readonly id: string;
  readonly title: string; // of the exercise
}

// How the class did: students who have not begun, points lost by criterion, outliers.
export function InsightCard({ client, id, title }: Props) {
  const { loaded, reload } = useRequest(`insight ${id}`, async (signal) => {
    const insight = await client.teaching.insight(id, signal);
    return insight.ok ? ok(wordedInsight(insight.value)) : insight;
  });
  // The figures count them among what is not scored yet, which they are not before an instructor decides.
  const quarantined = useRequest(`set aside ${id}`, (signal) =>
    client.attempts({ assignment: id, state: "quarantined", limit: kMostSetAside }, signal),
  );
  const setAside = quarantined.loaded.state === "ready" ? quarantined.loaded.value.items.length : 0;
  const save = (insight: AssignmentInsight) => {
    const { header, rows } = insightTable(insight);
    downloadFile(`${fileName(title, "class")}.csv`, "text/csv", csvText(header, rows));
  };
  const aside =
    loaded.state === "ready" && loaded.value.students.length > 0 ? (
      <button type="button" class="button small" onClick={() => save(loaded.value)}>
        {say("common.save_csv")}
      </button>
    ) : undefined;
  return (
    <Card title={say("insight.title")} aside={aside} className="insight">
      {loaded.state === "loading" && <Loading what={say("loading.insight")} />}
      {loaded.state === "failed" && (
        <ErrorNotice title={say("insight.failed")} message={loaded.error.message} onRetry={reload} />
      )}
      {setAside > 0 && (
        <Notice tone="warning">
          <p>
            {say("insight.set_aside", { count: setAside })}{" "}
            <a href={`/attempts?assignment=${id}&state=quarantined`}>{say("insight.show_set_aside")}</a>
          </p>
        </Notice>
      )}
      {loaded.state === "ready" && <Insight insight={loaded.value} />}
    </Card>
  );
}

function Insight({ insight }: { readonly insight: AssignmentInsight }) {
  const { summary, criteria, students, staff, gates } = insight;
  return (
    <>
      {students.length === 0 ? <Empty>{say("insight.no_student")}</Empty> : <Figures summary={summary} />}
      {insight.left_out > 0 && (
        <Notice tone="warning">
          <p>{say("insight.left_out", { count: insight.left_out })}</p>
        </Notice>
      )}
      {insight.unread > 0 && (
        <Notice tone="warning">
          <p>{say("insight.unread", { count: insight.unread })}</p>
        </Notice>
      )}
      {students.length > 0 && <p class="insight-say">{commonestText(insight)}</p>}
      {gates.map(({ name, title, taken }) => (
        <p key={name} class="insight-say">
          {say("insight.gate", { title, count: taken })}
        </p>
      ))}
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
      <div>
        <dt>{say("attempt_state.ticketed")}</dt>
        <dd>{say("count.of", { part: String(summary.not_started), whole: String(summary.students) })}</dd>
      </div>
      <div>
        <dt>{say("insight.begun")}</dt>
        <dd>{summary.waiting}</dd>
      </div>
      <div>
        <dt>{say("attempt_state.scored")}</dt>
        <dd>
          {summary.scored}
          {summary.failed > 0 && (
            <>
              {" "}
              <Badge tone="bad">{say("insight.critical", { count: summary.failed })}</Badge>
            </>
          )}
        </dd>
      </div>
      {summary.scores !== null && (
        <div>
          <dt>{say("insight.score_middle")}</dt>
          <dd>{middle(summary.scores, formatScore)}</dd>
        </div>
      )}
      {summary.times_s !== null && (
        <div>
          <dt>{say("insight.time_middle")}</dt>
          <dd>{middle(summary.times_s, formatDuration)}</dd>
        </div>
      )}
      {summary.scored > 0 && (
        <div>
          <dt>{say("insight.scores")}</dt>
          <dd>
            <Tenths counts={summary.score_tenths} what={say("insight.scores_said")} />
          </dd>
        </div>
      )}
    </dl>
  );
}

function middle({ lower, median, upper }: Spread, form: (value: number) => string): string {
  return say("insight.middle", { median: form(median), lower: form(lower), upper: form(upper) });
}

function Criteria({ insight: { criteria, commonest } }: { readonly insight: AssignmentInsight }) {
  return (
    <DataTable
      label={say("insight.by_criterion")}
      items={criteria}
      rowKey={(item) => item.name}
      dense
      columns={[
        {
          title: say("common.criterion"),
          cell: (item) => (
            <>
              {item.title}
              {item.name === commonest && (
                <>
                  {" "}
                  <Badge tone="warning">{say("insight.commonest_error")}</Badge>
                </>
              )}
            </>
          ),
        },
        {
          title: say("insight.points_mean"),
          number: true,
          cell: (item) =>
            item.judged === 0
              ? "–"
              : say("count.of", { part: formatPoints(item.mean_points), whole: formatPoints(item.max_points) }),
        },
        {
          title: say("insight.share"),
          cell: (item) =>
            item.judged > 0 && (
              <Tenths counts={item.earned_tenths} what={say("insight.share_of", { title: item.title })} />
            ),
        },
        {
          title: say("insight.lost_half"),
          number: true,
          cell: (item) =>
            item.judged === 0 ? (
              <span class="hint">{say("insight.not_judged")}</span>
            ) : (
              say("count.of", { part: String(item.half_lost), whole: String(item.judged) })
            ),
        },
        {
          title: say("insight.measured_middle"),
          cell: (item) =>
            item.values === null ? "–" : middle(item.values, (value) => formatQuantity(value, item.unit)),
        },
      ]}
    />
  );
}

function Waiting({ students }: { readonly students: AssignmentInsight["students"] }) {
  const names = (state: string) => students.filter((student) => student.state === state).map(({ person }) => person);
  const none = names("not_started");
  const begun = names("waiting");
  if (students.length === 0) return null;
  return (
    <section aria-label={say("attempt_state.ticketed")}>
      <h3>{say("insight.not_started", { count: none.length })}</h3>
      {none.length === 0 ? (
        <p class="hint">{say("insight.all_begun")}</p>
      ) : (
        <ul class="name-list">
          {none.map((person) => (
            <li key={person.id}>{person.display_name}</li>
          ))}
        </ul>
      )}
      {begun.length > 0 && (
        <>
          <h3>{say("insight.begun_count", { count: begun.length })}</h3>
          <ul class="name-list">
            {begun.map((person) => (
              <li key={person.id}>{person.display_name}</li>
            ))}
          </ul>
        </>
      )}
    </section>
  );
}

function Outliers({ insight }: { readonly insight: AssignmentInsight }) {
  const { students, summary } = insight;
  const outliers = outliersOf(insight);
  if (summary.scored === 0) return null;
  const byPerson = new Map(students.map((student) => [student.person.id, student]));
  return (
    <section aria-label={say("insight.far")}>
      <h3>{say("insight.far_count", { count: outliers.length })}</h3>
      {outliers.length === 0 ? (
        <p class="hint">{summary.scored < 8 ? say("insight.too_few") : say("insight.nothing_far")}</p>
      ) : (
        <ul class="say-list">
          {outliers.map((outlier) => {
            const student = byPerson.get(outlier.person_id);
            const name = student?.person.display_name ?? "";
            return (
              <li key={`${outlier.person_id} ${outlier.what} ${outlier.median}`}>
                {student?.attempt_id == null ? name : <a href={`/attempts/${student.attempt_id}`}>{name}</a>}:{" "}
                {outlierText(outlier, insight)}
              </li>
            );
          })}
        </ul>
      )}
    </section>
  );
}

// Apart from the class: who teaches it is in none of its figures.
function Staff({ staff }: { readonly staff: AssignmentInsight["staff"] }) {
  return (
    <section aria-label={say("insight.staff")}>
      <h3>{say("insight.staff_apart")}</h3>
      <DataTable
        label={say("insight.staff_attempts")}
        items={staff}
        rowKey={(row) => row.attempt_id}
        dense
        columns={[
          {
            title: say("account.name"),
            cell: (row) => <a href={`/attempts/${row.attempt_id}`}>{row.person.display_name}</a>,
          },
          { title: say("common.begun"), cell: (row) => formatDateTime(row.ticketed_ms) },
          { title: say("common.time"), number: true, cell: (row) => formatDuration(row.time_s) },
          { title: say("common.score"), number: true, cell: (row) => formatScore(row.score) },
          {
            title: say("insight.kind"),
            cell: (row) =>
              row.as_reference ? <Badge tone="neutral">{say("insight.reference_cut")}</Badge> : say("insight.own_try"),
          },
        ]}
      />
    </section>
  );
}
