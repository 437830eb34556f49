import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { failed } from "../../api/http";
import type { Assignment } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { say, sayWith } from "../../base/words";
import { Card, Waits } from "../../widgets/basics";
import { Confirm } from "../../widgets/dialog";

interface Props {
  readonly client: Client;
  readonly assignment: Assignment;
  readonly tag: string;
  readonly onMoved: () => void;
}

// An assignment stays with its version of the exercise until somebody moves it here.
export function MoveCard({ client, assignment, tag, onMoved }: Props) {
  const { exercise } = assignment;
  const [open, setOpen] = useState(false);
  if (exercise.newest_id === null || exercise.newest_version === null || exercise.newest_id === exercise.id)
    return null;
  const { newest_id: newest, newest_version: version } = exercise;
  return (
    <Card title={say("move.title")}>
      <p>
        {sayWith("move.text", {
          version: String(exercise.version),
          newer: <a href={`/exercises/${newest}`}>{say("move.version", { version: String(version) })}</a>,
        })}
      </p>
      <div class="button-row">
        <button type="button" class="button" onClick={() => setOpen(true)}>
          {say("move.ask", { version: String(version) })}
        </button>
      </div>
      {open && (
        <Confirm
          title={say("move.confirm", { version: String(version) })}
          action={say("move.move")}
          tone="neutral"
          onClose={() => setOpen(false)}
          onConfirm={() =>
            failed(
              client.post("/assignments/{id}/move", { id: assignment.id, body: { exercise_id: newest }, tag }),
              onMoved,
            )
          }
        >
          <WhatMoves client={client} assignment={assignment} newest={newest} />
        </Confirm>
      )}
    </Card>
  );
}

function WhatMoves({
  client,
  assignment,
  newest,
}: {
  readonly client: Client;
  readonly assignment: Assignment;
  readonly newest: string;
}) {
  const { loaded } = useRequest(`${assignment.id} ${newest}`, (signal) =>
    client.post("/assignments/{id}/move", { id: assignment.id, dry_run: true, body: { exercise_id: newest }, signal }),
  );
  if (loaded.state !== "ready") return <Waits loaded={loaded} what={say("loading.move")} failed={say("move.failed")} />;
  const { attempts, tickets, to_version: to } = loaded.value;
  return (
    <p>
      {attempts === 0
        ? say("move.none", { version: String(to) })
        : tickets === 0
          ? say("move.some", { version: String(to), count: attempts })
          : say("move.some_tickets", { version: String(to), count: attempts, tickets })}
    </p>
  );
}
