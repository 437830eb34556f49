import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Assignment } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { plural } from "../../base/format";
import { Card, ErrorNotice, Loading } from "../../widgets/basics";
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
  if (exercise.newest_id === null || exercise.newest_version === null || exercise.newest_id === exercise.id) return null;
  const { newest_id: newest, newest_version: version } = exercise;
  return (
    <Card title="A newer version">
      <p>This assignment is of version {exercise.version} of the exercise; <a href={`/exercises/${newest}`}>version {version}</a> is published.</p>
      <div class="button-row"><button type="button" class="button" onClick={() => setOpen(true)}>Move to version {version}…</button></div>
      {open && (
        <Confirm title={`Move to version ${version}?`} action="Move" tone="neutral" onClose={() => setOpen(false)}
                 onConfirm={async () => {
                   const result = await client.teaching.moveAssignment(assignment.id, newest, tag);
                   if (!result.ok) return result.error.message;
                   onMoved();
                   return undefined;
                 }}>
          <WhatMoves client={client} assignment={assignment} newest={newest} />
        </Confirm>
      )}
    </Card>
  );
}

function WhatMoves({ client, assignment, newest }: { readonly client: Client; readonly assignment: Assignment; readonly newest: string }) {
  const { loaded } = useRequest(`${assignment.id} ${newest}`, (signal) => client.teaching.lookAtMove(assignment.id, newest, signal));
  if (loaded.state === "loading") return <Loading what="what would move" />;
  if (loaded.state === "failed") return <ErrorNotice title="It cannot be moved" message={loaded.error.message} />;
  const { attempts, tickets, to_version: to } = loaded.value;
  return (
    <p>
      What begins from now on is of version {to}. {attempts === 0 ? "Nothing was begun with another version." : `${plural(attempts, "attempt")} made with another version ${attempts === 1 ? "keeps" : "keep"} it`}
      {attempts > 0 && (tickets > 0 ? `; ${plural(tickets, "of them is a ticket", "of them are tickets")} that nobody has used yet.` : ".")}
    </p>
  );
}
