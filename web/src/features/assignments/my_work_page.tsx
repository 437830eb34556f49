import type { Client } from "../../api/client";
import type { Assignment } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { unreachable } from "../../base/assert";
import { formatDateTime } from "../../base/format";
import { say } from "../../base/words";
import { Badge, Brief, Empty, PageTitle, Waits } from "../../widgets/basics";
import { part } from "../../widgets/part";
import { dueText, exerciseTitle, leftText, phaseOf, resultText } from "./assignment_text";

const Scores = part("my_progress", () => import("./my_progress"));

// A student's assignments, the earliest due time first.
export function MyWorkPage({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("assignments", (signal) => client.all("/assignments", { signal }));
  const now = Date.now();
  return (
    <>
      <PageTitle document={say("nav.my_work")}>{say("nav.my_work")}</PageTitle>
      <Waits loaded={loaded} reload={reload} what={say("loading.my_work")} failed={say("my_work.failed")} />
      {loaded.state === "ready" &&
        (loaded.value.length === 0 ? (
          <Empty>{say("my_work.none")}</Empty>
        ) : (
          <ul class="card-list">
            {loaded.value.map((assignment) => (
              <li key={assignment.id}>
                <AssignmentCard client={client} assignment={assignment} now={now} />
              </li>
            ))}
          </ul>
        ))}
    </>
  );
}

interface CardProps {
  readonly client: Client;
  readonly assignment: Assignment;
  readonly now: number;
}

function AssignmentCard({ client, assignment, now }: CardProps) {
  const { exercise, mine } = assignment;
  const used = mine?.attempts_used ?? 0;
  return (
    <article class="card exercise">
      <div class="card-head">
        <h2>
          {exercise.id === null ? (
            exerciseTitle(assignment)
          ) : (
            <a href={`/exercises/${exercise.id}`}>{exerciseTitle(assignment)}</a>
          )}
        </h2>
        <span class="flags">
          {assignment.exam && <Badge tone="warning">{say("attempt_flag.exam")}</Badge>}
          <PhaseBadge assignment={assignment} now={now} />
        </span>
      </div>
      <dl class="facts">
        {now < assignment.opens_ms && (
          <div>
            <dt>{say("assignments.opens")}</dt>
            <dd>{formatDateTime(assignment.opens_ms)}</dd>
          </div>
        )}
        <div>
          <dt>{say("assignments.due")}</dt>
          <dd>{dueText(assignment, now)}</dd>
        </div>
        <div>
          <dt>{say("nav.attempts")}</dt>
          <dd>{madeText(leftText({ attempts_left: mine?.attempts_left ?? null }), used)}</dd>
        </div>
        {mine !== null && used > 0 && (
          <div>
            <dt>{say("my_work.result")}</dt>
            <dd>{resultText(mine.grade, assignment.counting)}</dd>
          </div>
        )}
        {assignment.stations.length > 0 && (
          <div>
            <dt>{say("my_work.where")}</dt>
            <dd>{assignment.stations.map((station) => station.name).join(", ")}</dd>
          </div>
        )}
      </dl>
      {assignment.exam && <p class="hint">{say("my_work.exam")}</p>}
      {mine !== null && mine.refusal !== "" && <p class="hint">{refusalText(mine.refusal)}</p>}
      {used > 0 && (
        <Scores show={({ MyProgress }) => <MyProgress client={client} assignment={assignment.id} used={used} />} />
      )}
      {used > 0 && exercise.id !== null && (
        <p>
          <a href={`/attempts?exercise=${exercise.id}`}>
            <Brief
              shown={say("nav.my_attempts")}
              full={say("my_work.attempts_at", { title: exerciseTitle(assignment) })}
            />
          </a>
        </p>
      )}
    </article>
  );
}

function refusalText(term: "opens" | "due" | "attempt_limit"): string {
  switch (term) {
    case "opens":
      return say("refusal.opens");
    case "due":
      return say("refusal.due");
    case "attempt_limit":
      return say("refusal.attempt_limit");
    default:
      return unreachable(term);
  }
}

function madeText(left: string, made: number): string {
  return made === 0 ? left : say("my_work.left_and_made", { left, count: made });
}

export function PhaseBadge({ assignment, now }: { readonly assignment: Assignment; readonly now: number }) {
  const phase = phaseOf(assignment, now);
  switch (phase) {
    case "before":
      return <Badge tone="neutral">{say("phase.before")}</Badge>;
    case "open":
      return <Badge tone="good">{say("phase.open")}</Badge>;
    case "late":
      return <Badge tone="warning">{say("phase.late")}</Badge>;
    case "closed":
      return <Badge tone="neutral">{say("phase.closed")}</Badge>;
    default:
      return unreachable(phase);
  }
}
