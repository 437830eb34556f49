import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { AuditEntry } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { usePages } from "../../api/use_pages";
import { csvText } from "../../base/csv";
import { downloadText } from "../../base/download";
import { formatDateTime } from "../../base/format";
import { ok } from "../../base/result";
import { Card, PageTitle } from "../../widgets/basics";
import { TextField, TimeField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { type Column, DataTable } from "../../widgets/table";

const kPageSize = 100;

interface Props {
  readonly client: Client;
  readonly query: URLSearchParams;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
}

interface Filter {
  readonly actor: string;                       // id of a person
  readonly login: string;                       // of that person
  readonly action: string;
  readonly object: string;
  readonly from_ms: number;
  readonly until_ms: number;
}

// Who changed what, newest first.
export function AuditPage({ client, query, onQuery }: Props) {
  const filter: Filter = {
    actor: query.get("actor") ?? "", login: query.get("login") ?? "", action: query.get("action") ?? "", object: query.get("object") ?? "",
    from_ms: Number(query.get("from_ms") ?? 0), until_ms: Number(query.get("until_ms") ?? 0),
  };
  const pages = usePages(JSON.stringify(filter), (cursor, signal) =>
    client.operations.audit({ actor: filter.actor, action: filter.action, object: filter.object, from_ms: filter.from_ms || undefined, until_ms: filter.until_ms || undefined, cursor, limit: kPageSize }, signal));
  return (
    <>
      <div class="toolbar">
        <PageTitle document="Audit">Audit</PageTitle>
        <button type="button" class="button" disabled={pages.items.length === 0} onClick={() => save(pages.items)}>Save what is shown as CSV</button>
      </div>
      <Filters key={JSON.stringify(filter)} client={client} filter={filter} onQuery={onQuery} />
      <PagedList pages={pages} what="audit entries" empty="No change matches.">
        {(entries) => <Card className="flush"><Entries client={client} entries={entries} /></Card>}
      </PagedList>
    </>
  );
}

// People are told by their id in the trail, because names change: those who are there get their name.
function Entries({ client, entries }: { readonly client: Client; readonly entries: readonly AuditEntry[] }) {
  const ids = [...new Set(entries.flatMap((entry) => personId(entry.actor) ?? []))].sort();
  const names = useRequest(ids.join(" "), async (signal) => {
    const found = await Promise.all(ids.map((id) => client.people.get(id, signal)));
    return ok(new Map(found.flatMap((person) => person.ok ? [[person.value.value.id, person.value.value.display_name] as const] : [])));
  });
  const known = names.loaded.state === "ready" ? names.loaded.value : undefined;
  const who = ({ actor }: AuditEntry) => {
    const id = personId(actor);
    const name = id === undefined ? undefined : known?.get(id);
    return id === undefined || name === undefined ? <span class="json">{actor}</span> : <><a href={`/people/${id}`}>{name}</a>{actor.slice(id.length)}</>;
  };
  return <DataTable label="Audit, newest first" items={entries} columns={[kWhen, { title: "Who", cell: who }, ...kColumns]} />;
}

// "UUID (page)"
function personId(actor: string): string | undefined {
  return /^[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}(?= |$)/.exec(actor)?.[0];
}

const kWhen: Column<AuditEntry> = { title: "When", cell: (entry) => <span class="nowrap">{formatDateTime(entry.at_ms)}</span> };
const kColumns: readonly Column<AuditEntry>[] = [
  { title: "What", cell: (entry) => <code>{entry.action}</code> },
  { title: "On", cell: (entry) => <code class="json">{entry.object}</code> },
  { title: "Before", cell: (entry) => <code class="json">{entry.before === "" ? "–" : entry.before}</code> },
  { title: "After", cell: (entry) => <code class="json">{entry.after === "" ? "–" : entry.after}</code> },
];

function Filters({ client, filter, onQuery }: { readonly client: Client; readonly filter: Filter; readonly onQuery: Props["onQuery"] }) {
  const [draft, setDraft] = useState(filter);
  const [problem, setProblem] = useState<string>();
  const set = (part: Partial<Filter>) => setDraft((now) => ({ ...now, ...part }));
  const submit = async (event: Event) => {
    event.preventDefault();
    const login = draft.login.trim();
    const actor = login === "" ? "" : login === filter.login ? filter.actor : await idOf(client, login);
    setProblem(actor === undefined ? "Nobody has this login." : undefined);
    if (actor === undefined) return;
    onQuery({ actor, login, action: draft.action.trim(), object: draft.object.trim(),
              from_ms: draft.from_ms > 0 ? String(draft.from_ms) : "", until_ms: draft.until_ms > 0 ? String(draft.until_ms) : "" });
  };
  return (
    <form class="filters" role="search" onSubmit={(event) => void submit(event)}>
      <TextField label="Who (login)" value={draft.login} onValue={(login) => set({ login })} maxLength={64} problem={problem} />
      <TextField label="What" value={draft.action} onValue={(action) => set({ action })} maxLength={100} hint="As person.create; person. for every change of a person" />
      <TextField label="On (id)" value={draft.object} onValue={(object) => set({ object })} maxLength={100} />
      <TimeField label="From" value={draft.from_ms} onValue={(fromMs) => set({ from_ms: fromMs })} />
      <TimeField label="Until" value={draft.until_ms} onValue={(untilMs) => set({ until_ms: untilMs })} />
      <button type="submit" class="button">Search</button>
      <button type="button" class="button quiet" onClick={() => onQuery({})}>Clear</button>
    </form>
  );
}

async function idOf(client: Client, login: string): Promise<string | undefined> {
  const found = await client.people.list({ text: login });
  return found.ok ? found.value.items.find((person) => person.login === login)?.id : undefined;
}

function save(entries: readonly AuditEntry[]): void {
  downloadText("audit.csv", "text/csv", csvText(["time_utc", "who", "what", "on", "before", "after"],
    entries.map((entry) => [new Date(entry.at_ms).toISOString(), entry.actor, entry.action, entry.object, entry.before, entry.after])));
}
