import { useState } from "preact/hooks";
import type { SessionEntry } from "../api/types";
import { formatDateTime } from "../base/format";
import { relativeTime } from "../base/local_time";
import { Badge, Empty } from "./basics";
import { Confirm } from "./dialog";
import { DataTable } from "./table";

interface Props {
  readonly sessions: readonly SessionEntry[];
  readonly label: string;
  readonly onEnd: (id: string) => Promise<string | undefined>;  // the reason when it failed
}

function deviceText({ via, device }: SessionEntry): string {
  if (via === "station") return device === "" ? "a station" : `the station ${device}`;
  return device === "" ? "a browser" : device;
}

// Where somebody is signed in, each with a button that ends it.
export function SessionsTable({ sessions, label, onEnd }: Props) {
  const [ending, setEnding] = useState<SessionEntry>();
  if (sessions.length === 0) return <Empty>Not signed in anywhere.</Empty>;
  return (
    <>
      <DataTable label={label} items={sessions} rowKey={(session) => session.id} columns={[
        { title: "Signed in", cell: (session) => formatDateTime(session.created_ms) },
        { title: "With", cell: (session) => deviceText(session) },
        { title: "From", cell: (session) => session.address === "" ? "–" : <code>{session.address}</code> },
        { title: "Used last", cell: (session) => session.current ? <Badge tone="neutral">This one</Badge> : relativeTime(session.last_used_ms, Date.now()) },
        { title: "End", hideTitle: true, cell: (session) => session.current ? null : (
          <div class="row-tools"><button type="button" class="button small" onClick={() => setEnding(session)}>End…</button></div>) },
      ]} />
      {ending !== undefined && (
        <Confirm title="End this session?" action="End session" onClose={() => setEnding(undefined)} onConfirm={() => onEnd(ending.id)}>
          <p>Signed in {formatDateTime(ending.created_ms)} with {deviceText(ending)}. Whoever uses it has to sign in again.</p>
        </Confirm>
      )}
    </>
  );
}
