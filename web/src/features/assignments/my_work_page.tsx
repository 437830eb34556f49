import type { Client } from "../../api/client";
import type { Assignment } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { unreachable } from "../../base/assert";
import { formatDateTime, plural } from "../../base/format";
import { Badge, Empty, ErrorNotice, Loading, PageTitle } from "../../widgets/basics";
import { dueText, exerciseTitle, leftText, phaseOf, resultText } from "./assignment_text";

// What a student has to do, what is due first on top.
export function MyWorkPage({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("assignments", (signal) => client.teaching.assignments({}, signal));
  const now = Date.now();
  return (
    <>
      <PageTitle document="My work">My work</PageTitle>
      {loaded.state === "loading" && <Loading what="your assignments" />}
      {loaded.state === "failed" && <ErrorNotice title="Your assignments could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (loaded.value.length === 0
        ? <Empty>Nothing is assigned to you yet. Your instructor does that.</Empty>
        : <ul class="card-list">{loaded.value.map((assignment) => <li key={assignment.id}><AssignmentCard assignment={assignment} now={now} /></li>)}</ul>)}
    </>
  );
}

function AssignmentCard({ assignment, now }: { readonly assignment: Assignment; readonly now: number }) {
  const { exercise, mine } = assignment;
  const used = mine?.attempts_used ?? 0;
  return (
    <article class="card exercise">
      <div class="card-head">
        <h2>{exercise.id === null ? exerciseTitle(assignment) : <a href={`/exercises/${exercise.id}`}>{exerciseTitle(assignment)}</a>}</h2>
        <span class="flags">{assignment.exam && <Badge tone="warning">Exam</Badge>}<PhaseBadge assignment={assignment} now={now} /></span>
      </div>
      <dl class="facts">
        {now < assignment.opens_ms && <div><dt>Opens</dt><dd>{formatDateTime(assignment.opens_ms)}</dd></div>}
        <div><dt>Due</dt><dd>{dueText(assignment, now)}</dd></div>
        <div><dt>Attempts</dt><dd>{leftText({ attempts_left: mine?.attempts_left ?? null })}{used > 0 && `, ${plural(used, "attempt")} made`}</dd></div>
        {mine !== null && used > 0 && <div><dt>Result</dt><dd>{resultText(mine.grade, assignment.counting)}</dd></div>}
        {assignment.stations.length > 0 && <div><dt>Where</dt><dd>{assignment.stations.map((station) => station.name).join(", ")}</dd></div>}
      </dl>
      {assignment.exam && <p class="hint">In an exam the score is shown after your instructor releases it.</p>}
      {mine !== null && mine.refusal !== "" && <p class="hint">{mine.refusal}</p>}
      {used > 0 && exercise.id !== null && <p><a href={`/attempts?exercise=${exercise.id}`}>My attempts<span class="hidden"> at {exerciseTitle(assignment)}</span></a></p>}
    </article>
  );
}

export function PhaseBadge({ assignment, now }: { readonly assignment: Assignment; readonly now: number }) {
  const phase = phaseOf(assignment, now);
  switch (phase) {
    case "before": return <Badge tone="neutral">Not open yet</Badge>;
    case "open": return <Badge tone="good">Open</Badge>;
    case "late": return <Badge tone="warning">Late, still accepted</Badge>;
    case "closed": return <Badge tone="neutral">Closed</Badge>;
    default: return unreachable(phase);
  }
}
