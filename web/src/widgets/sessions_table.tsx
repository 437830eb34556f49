import { useState } from "preact/hooks";
import type { SessionEntry } from "../api/types";
import { formatDateTime } from "../base/format";
import { relativeTime } from "../base/local_time";
import { say } from "../base/words";
import { Badge, Empty } from "./basics";
import { Confirm } from "./dialog";
import { DataTable } from "./table";

interface Props {
  readonly sessions: readonly SessionEntry[];
  readonly label: string;
  readonly onEnd: (id: string) => Promise<string | undefined>; // the reason when it failed
}

function deviceText({ via, device }: SessionEntry): string {
  if (via === "station")
    return device === "" ? say("sessions.a_station") : say("sessions.the_station", { name: device });
  return device === "" ? say("sessions.a_browser") : device;
}

// Where somebody is signed in, each with a button that ends it.
export function SessionsTable({ sessions, label, onEnd }: Props) {
  const [ending, setEnding] = useState<SessionEntry>();
  if (sessions.length === 0) return <Empty>{say("sessions.none")}</Empty>;
  return (
    <>
      <DataTable
        label={label}
        items={sessions}
        rowKey={(session) => session.id}
        columns={[
          { title: say("sessions.begun"), cell: (session) => formatDateTime(session.created_ms) },
          { title: say("sessions.device"), cell: (session) => deviceText(session) },
          {
            title: say("sessions.from"),
            cell: (session) => (session.address === "" ? "–" : <code>{session.address}</code>),
          },
          {
            title: say("sessions.used"),
            cell: (session) =>
              session.current ? (
                <Badge tone="neutral">{say("sessions.this_one")}</Badge>
              ) : (
                relativeTime(session.last_used_ms, Date.now())
              ),
          },
          {
            title: say("sessions.end_column"),
            hideTitle: true,
            cell: (session) =>
              session.current ? null : (
                <div class="row-tools">
                  <button type="button" class="button small" onClick={() => setEnding(session)}>
                    {say("sessions.end_ask")}
                  </button>
                </div>
              ),
          },
        ]}
      />
      {ending !== undefined && (
        <Confirm
          title={say("sessions.end_title")}
          action={say("sessions.end")}
          onClose={() => setEnding(undefined)}
          onConfirm={() => onEnd(ending.id)}
        >
          <p>{say("sessions.end_text", { begun: formatDateTime(ending.created_ms), device: deviceText(ending) })}</p>
        </Confirm>
      )}
    </>
  );
}
