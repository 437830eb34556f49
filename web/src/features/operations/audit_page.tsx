import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { AuditEntry } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { usePages } from "../../api/use_pages";
import { csvText } from "../../base/csv";
import { downloadFile } from "../../base/download";
import { formatDateTime } from "../../base/format";
import { ok } from "../../base/result";
import { say, sayIf, sayIfWith, sayWith } from "../../base/words";
import { Card, PageTitle } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { TextField, TimeField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { type Column, DataTable } from "../../widgets/table";
import { type Detail, detailsOf, peopleIn, personOf, shortId, thingOf, whereText } from "./audit_text";

const kPageSize = 100;

interface Props {
  readonly client: Client;
  readonly query: URLSearchParams;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
}

interface Filter {
  readonly actor: string; // id of a person
  readonly login: string; // of that person
  readonly action: string;
  readonly object: string;
  readonly from_ms: number;
  readonly until_ms: number;
}

// Who changed what, newest first.
export function AuditPage({ client, query, onQuery }: Props) {
  const filter: Filter = {
    actor: query.get("actor") ?? "",
    login: query.get("login") ?? "",
    action: query.get("action") ?? "",
    object: query.get("object") ?? "",
    from_ms: Number(query.get("from_ms") ?? 0),
    until_ms: Number(query.get("until_ms") ?? 0),
  };
  const pages = usePages(JSON.stringify(filter), (cursor, signal) =>
    client.page("/audit", {
      actor: filter.actor,
      action: filter.action,
      object: filter.object,
      from_ms: filter.from_ms || undefined,
      until_ms: filter.until_ms || undefined,
      cursor,
      limit: kPageSize,
      signal,
    }),
  );
  return (
    <>
      <div class="toolbar">
        <PageTitle document={say("nav.audit")}>{say("nav.audit")}</PageTitle>
        <Button
          kind=""
          blocked={pages.items.length === 0 ? say("audit.none") : undefined}
          onClick={() => save(pages.items)}
        >
          {say("audit.save")}
        </Button>
      </div>
      <Filters key={JSON.stringify(filter)} client={client} filter={filter} onQuery={onQuery} />
      <PagedList pages={pages} list="audit" empty={say("audit.none")}>
        {(entries) => (
          <Card className="flush">
            <Entries client={client} entries={entries} />
          </Card>
        )}
      </PagedList>
    </>
  );
}

// The trail identifies people by id, because names change: those who are there get their name.
function Entries({ client, entries }: { readonly client: Client; readonly entries: readonly AuditEntry[] }) {
  const ids = peopleIn(entries);
  const names = useRequest(ids.join(" "), async (signal) => {
    const found = await Promise.all(ids.map((id) => client.tagged("GET", "/people/{id}", { id, signal })));
    return ok(
      new Map(
        found.flatMap((person) =>
          person.ok ? [[person.value.value.id, person.value.value.display_name] as const] : [],
        ),
      ),
    );
  });
  const known: ReadonlyMap<string, string> = names.loaded.state === "ready" ? names.loaded.value : new Map();
  const nameOf = (id: string) => known.get(id) ?? shortId(id);
  return (
    <DataTable
      label={say("audit.table")}
      items={entries}
      dense
      columns={[
        kWhen,
        { title: say("audit.who_did"), cell: (entry) => <Sentence entry={entry} known={known} /> },
        { title: say("audit.detail"), cell: (entry) => <Details details={detailsOf(entry, nameOf)} /> },
      ]}
    />
  );
}

function Sentence({ entry, known }: { readonly entry: AuditEntry; readonly known: ReadonlyMap<string, string> }) {
  const person = personOf(entry.actor);
  const thing = thingOf(entry);
  const linked = (id: string, otherwise: string) =>
    known.has(id) ? <a href={`/people/${id}`}>{known.get(id)}</a> : <span title={id}>{otherwise}</span>;
  return (
    <span title={entry.action}>
      {told(
        entry.action,
        person === undefined ? (
          actorText(entry.actor)
        ) : (
          <>
            {linked(person, shortId(person))}
            {whereText(entry.actor, person)}
          </>
        ),
        thing === undefined ? (
          ""
        ) : thing.kind === "attempt" ? (
          <a href={`/attempts/${thing.id}`} title={thing.id}>
            {thing.text}
          </a>
        ) : thing.kind === "person" ? (
          linked(thing.id, thing.text)
        ) : (
          <span class="hint" title={thing.id}>
            {thing.text}
          </span>
        ),
      )}
    </span>
  );
}

// What the page does not know is shown by its own name.
function told(action: string, who: ComponentChildren, what: ComponentChildren): ComponentChildren {
  return (
    sayIfWith<ComponentChildren>(`audit_action.${action.replace(".", "_")}`, { who, what }) ??
    sayWith<"audit_action.other", ComponentChildren>("audit_action.other", { who, action, what })
  );
}

// A part of the server that acts by itself, or a station by its name.
function actorText(actor: string): string {
  return sayIf(`audit_actor.${actor.replaceAll(/[^a-z]+/g, "_")}`) ?? actor.charAt(0).toUpperCase() + actor.slice(1);
}

function Details({ details }: { readonly details: readonly Detail[] }) {
  if (details.length === 0) return null;
  return (
    <ul class="audit-details">
      {details.map(({ name, before, after }) => (
        <li key={name}>
          {name}:{" "}
          {before === "" ? (
            after
          ) : after === "" ? (
            say("audit.taken_away", { before })
          ) : (
            <>
              {before} → {after}
            </>
          )}
        </li>
      ))}
    </ul>
  );
}

const kWhen: Column<AuditEntry> = {
  get title() {
    return say("common.when");
  },
  cell: (entry) => <span class="nowrap">{formatDateTime(entry.at_ms)}</span>,
};

function Filters({
  client,
  filter,
  onQuery,
}: {
  readonly client: Client;
  readonly filter: Filter;
  readonly onQuery: Props["onQuery"];
}) {
  const [draft, setDraft] = useState(filter);
  const [problem, setProblem] = useState<string>();
  const set = (part: Partial<Filter>) => setDraft((now) => ({ ...now, ...part }));
  const submit = async (event: Event) => {
    event.preventDefault();
    const login = draft.login.trim();
    const actor = login === "" ? "" : login === filter.login ? filter.actor : await idOf(client, login);
    setProblem(actor === undefined ? say("audit.nobody") : undefined);
    if (actor === undefined) return;
    onQuery({
      actor,
      login,
      action: draft.action.trim(),
      object: draft.object.trim(),
      from_ms: draft.from_ms > 0 ? String(draft.from_ms) : "",
      until_ms: draft.until_ms > 0 ? String(draft.until_ms) : "",
    });
  };
  return (
    <form class="filters" role="search" onSubmit={(event) => void submit(event)}>
      <TextField
        label={say("audit.who")}
        value={draft.login}
        onValue={(login) => set({ login })}
        maxLength={64}
        problem={problem}
      />
      <TextField
        label={say("audit.what")}
        value={draft.action}
        onValue={(action) => set({ action })}
        maxLength={100}
        hint={say("audit.what_hint")}
      />
      <TextField label={say("audit.on")} value={draft.object} onValue={(object) => set({ object })} maxLength={100} />
      <TimeField label={say("audit.from")} value={draft.from_ms} onValue={(fromMs) => set({ from_ms: fromMs })} />
      <TimeField label={say("audit.until")} value={draft.until_ms} onValue={(untilMs) => set({ until_ms: untilMs })} />
      <button type="submit" class="button">
        {say("people.search")}
      </button>
      <button type="button" class="button quiet" onClick={() => onQuery({})}>
        {say("audit.clear")}
      </button>
    </form>
  );
}

async function idOf(client: Client, login: string): Promise<string | undefined> {
  const found = await client.page("/people", { text: login });
  return found.ok ? found.value.items.find((person) => person.login === login)?.id : undefined;
}

function save(entries: readonly AuditEntry[]): void {
  downloadFile(
    "audit.csv",
    "text/csv",
    csvText(
      ["time_utc", "who", "what", "on", "before", "after"],
      entries.map((entry) => [
        new Date(entry.at_ms).toISOString(),
        entry.actor,
        entry.action,
        entry.object,
        entry.before,
        entry.after,
      ]),
    ),
  );
}
