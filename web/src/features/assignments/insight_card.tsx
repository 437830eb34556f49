import type { Client } from "../../api/client";
import type { Assignment, AssignmentInsight, Exercise, Spread } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { criterionTitle, mistakeText, wordedInsight } from "../../api/worded";
import { csvText } from "../../base/csv";
import { downloadFile, fileName } from "../../base/download";
import { formatDateTime, formatDuration, formatPoints, formatQuantity, formatScore } from "../../base/format";
import { namesIn } from "../../base/names";
import { ok } from "../../base/result";
import { say } from "../../base/words";
import { Badge, Card, Empty, Folded, Notice, Waits } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import { Tenths } from "../../widgets/tenths";
import { exerciseTitle } from "./assignment_text";
import { commonestText, insightTable, outliersOf, outlierText } from "./insight";
import { MistakeMap } from "./mistake_map";

const kMaxSetAside = 200;

interface Props {
  readonly client: Client;
  readonly assignment: Assignment;
}

// How the class did: its mistakes and where they are, points lost by criterion, students who have not begun, outliers.
export function InsightCard({ client, assignment }: Props) {
  const { id, exercise } = assignment;
  const { loaded, reload } = useRequest(`insight ${id}`, async (signal) => {
    const insight = await client.get("/assignments/{id}/insight", { id, signal });
    return insight.ok ? ok(wordedInsight(insight.value)) : insight;
  });
  // The figures count them among what is not scored yet, which they are not before an instructor decides.
  const quarantined = useRequest(`set aside ${id}`, (signal) =>
    client.page("/attempts", { assignment: id, state: "quarantined", limit: kMaxSetAside, signal }),
  );
  const drawn = useRequest(exercise.id ?? undefined, (signal) =>
    client.tagged("GET", "/exercises/{id}", { id: exercise.id ?? "", signal }),
  );
  const target = drawn.loaded.state === "ready" ? drawn.loaded.value.value.target : undefined;
  const setAside = quarantined.loaded.state === "ready" ? quarantined.loaded.value.items.length : 0;
  const save = (insight: AssignmentInsight) => {
    const { header, rows } = insightTable(insight);
    downloadFile(`${fileName(exerciseTitle(assignment), "class")}.csv`, "text/csv", csvText(header, rows));
  };
  const aside =
    loaded.state === "ready" && loaded.value.students.length > 0 ? (
      <button type="button" class="button small" onClick={() => save(loaded.value)}>
        {say("common.save_csv")}
      </button>
    ) : undefined;
  return (
    <Card title={say("insight.title")} aside={aside} className="insight">
      <Waits loaded={loaded} reload={reload} what={say("loading.insight")} failed={say("insight.failed")} />
      {setAside > 0 && (
        <Notice tone="warning">
          <p>
            {say("insight.set_aside", { count: setAside })}{" "}
            <a href={`/attempts?assignment=${id}&state=quarantined`}>{say("insight.show_set_aside")}</a>
          </p>
        </Notice>
      )}
      {loaded.state === "ready" && <Insight insight={loaded.value} target={target} />}
    </Card>
  );
}

function Insight({
  insight,
  target,
}: {
  readonly insight: AssignmentInsight;
  readonly target: Exercise["target"] | undefined; // undefined: not read
}) {
  const { summary, criteria, mistakes, students, staff } = insight;
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
      {mistakes.length > 0 && <Mistakes insight={insight} target={target} />}
      {summary.scored > 0 && criteria.length > 0 && (
        <>
          <h3>{say("insight.by_criterion")}</h3>
          <Criteria criteria={criteria} />
          <Folded title={say("insight.by_student")} content={() => <Students insight={insight} />} />
        </>
      )}
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

const kShown = 10; // mistakes; the others are unfolded

function Mistakes({
  insight: { mistakes, commonest, summary },
  target,
}: {
  readonly insight: AssignmentInsight;
  readonly target: Exercise["target"] | undefined;
}) {
  const numbered = mistakes.map((mistake, i) => ({ ...mistake, number: i + 1, commonest: i === commonest }));
  const [shown, rest] = [numbered.slice(0, kShown), numbered.slice(kShown)];
  const table = (items: typeof numbered, label: string) => (
    <DataTable
      label={label}
      items={items}
      rowKey={({ number }) => String(number)}
      dense
      columns={[
        {
          title: say("insight.mistake"),
          cell: (item) => (
            <span class="mistake-cell">
              <span class="mistake-number">{item.number}</span>
              <span>
                {mistakeText(item)}
                {item.commonest && (
                  <>
                    {" "}
                    <Badge tone="warning">{say("insight.commonest_mistake")}</Badge>
                  </>
                )}
              </span>
            </span>
          ),
        },
        {
          title: say("insight.made_by"),
          number: true,
          cell: ({ students }) => say("count.of", { part: String(students), whole: String(summary.scored) }),
        },
        { title: say("insight.points_class"), number: true, cell: ({ points }) => formatPoints(points) },
      ]}
    />
  );
  return (
    <>
      <h3>{say("insight.mistakes")}</h3>
      <div class="class-mistakes">
        <div>
          {table(shown, say("insight.mistakes"))}
          {rest.length > 0 && (
            <Folded
              title={say("insight.more_mistakes", { count: rest.length })}
              content={() => table(rest, say("insight.more_mistakes", { count: rest.length }))}
            />
          )}
          <p class="hint">{say("insight.mistakes_hint")}</p>
        </div>
        {target !== undefined && <MistakeMap mistakes={shown} target={target} of={summary.scored} />}
      </div>
    </>
  );
}

function Criteria({ criteria }: { readonly criteria: AssignmentInsight["criteria"] }) {
  return (
    <DataTable
      label={say("insight.by_criterion")}
      items={criteria}
      rowKey={(item) => item.name}
      dense
      columns={[
        { title: say("common.criterion"), cell: criterionTitle },
        {
          title: say("insight.lost_mean"),
          number: true,
          cell: (item) => (item.judged === 0 ? "–" : formatPoints(item.mean_lost)),
        },
        {
          title: say("insight.lost_middle"),
          cell: (item) => (item.lost === null ? "–" : middle(item.lost, formatPoints)),
        },
        {
          title: say("insight.to_change"),
          number: true,
          cell: (item) =>
            item.judged === 0 ? (
              <span class="hint">{say("insight.not_judged")}</span>
            ) : (
              say("count.of", { part: String(item.to_change), whole: String(item.judged) })
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

function Students({ insight: { criteria, students } }: { readonly insight: AssignmentInsight }) {
  type Student = AssignmentInsight["students"][number];
  const name = namesIn(students.map(({ person }) => person));
  return (
    <DataTable
      label={say("insight.by_student")}
      items={students.filter(({ state }) => state === "scored")}
      rowKey={({ person }) => person.id}
      dense
      columns={[
        {
          title: say("common.student"),
          cell: ({ person, attempt_id: attempt }) =>
            attempt === null ? name(person) : <a href={`/attempts/${attempt}`}>{name(person)}</a>,
        },
        { title: say("common.score"), number: true, cell: ({ score }) => formatScore(score) },
        ...criteria.map((criterion, i) => ({
          title: criterionTitle(criterion),
          number: true,
          cell: ({ lost }: Student) => lostText(lost[i]),
        })),
      ]}
    />
  );
}

// Missing at the end, or null: there were none to lose.
function lostText(lost: number | null | undefined): string {
  if (lost === null || lost === undefined) return "–";
  const text = formatPoints(lost);
  return text === "0" ? text : `−${text}`;
}

function Waiting({ students }: { readonly students: AssignmentInsight["students"] }) {
  const names = (state: string) => students.filter((student) => student.state === state).map(({ person }) => person);
  const name = namesIn(students.map(({ person }) => person));
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
            <li key={person.id}>{name(person)}</li>
          ))}
        </ul>
      )}
      {begun.length > 0 && (
        <>
          <h3>{say("insight.begun_count", { count: begun.length })}</h3>
          <ul class="name-list">
            {begun.map((person) => (
              <li key={person.id}>{name(person)}</li>
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
  const nameOf = namesIn(students.map(({ person }) => person));
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
            const name = student === undefined ? "" : nameOf(student.person);
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
  const name = namesIn(staff.map(({ person }) => person));
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
            cell: (row) => <a href={`/attempts/${row.attempt_id}`}>{name(row.person)}</a>,
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
