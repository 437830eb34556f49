import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Tagged } from "../../api/http";
import type { Cohort, CohortMember } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useEdit } from "../../api/use_edit";
import { useRequest } from "../../api/use_request";
import { Badge, Card, Empty, ErrorNotice, Loading, PageTitle } from "../../widgets/basics";
import { Confirm } from "../../widgets/dialog";
import { EditNotices } from "../../widgets/edit_notices";
import { CheckField, TextField } from "../../widgets/form";
import { DataTable } from "../../widgets/table";
import { GradesCard } from "./grades_card";

interface Props {
  readonly client: Client;
  readonly id: string;
  readonly admin: boolean;
}

export function CohortPage({ client, id, admin }: Props) {
  const { loaded, reload } = useRequest(id, (signal) => client.people.cohort(id, signal));
  if (loaded.state === "loading") return <Loading what="the cohort" />;
  if (loaded.state === "failed") {
    return <><PageTitle document="Cohort">Cohort</PageTitle><ErrorNotice title="The cohort could not be loaded" message={loaded.error.message} onRetry={reload} /></>;
  }
  const cohort = loaded.value.value;
  return (
    <>
      <nav class="trail" aria-label="Where you are"><a href="/cohorts">Cohorts</a></nav>
      <div class="title-row">
        <PageTitle document={cohort.name}>{cohort.name}</PageTitle>
        {cohort.archived_ms > 0 && <Badge tone="neutral">Archived</Badge>}
      </div>
      <p class="byline"><a href={`/attempts?cohort=${cohort.id}`}>Attempts</a>{" · "}<a href={`/grading?cohort=${cohort.id}`}>Grading</a>{" · "}<a href={`/assignments?cohort=${cohort.id}`}>Assignments</a></p>
      <GradesCard client={client} cohort={cohort} />
      <div class={admin ? "columns" : ""}>
        <Members client={client} cohort={cohort} admin={admin} onChanged={reload} />
        {admin && <Card title="Details"><Details key={loaded.value.tag} client={client} read={loaded.value} onRead={reload} /></Card>}
      </div>
    </>
  );
}

const kCompared = [
  { title: "Name", text: (cohort: Cohort) => cohort.name },
  { title: "Archived", text: (cohort: Cohort) => cohort.archived_ms > 0 ? "yes" : "no" },
];

function Details({ client, read, onRead }: { readonly client: Client; readonly read: Tagged<Cohort>; readonly onRead: () => void }) {
  const edit = useEdit(read, ({ name, archived_ms }, tag) => client.people.editCohort(read.value.id, { name: name.trim(), archived: archived_ms > 0 }, tag), onRead);
  const submit = (event: Event) => {
    event.preventDefault();
    void edit.save();
  };
  return (
    <form class="form" onSubmit={submit}>
      <TextField label="Name" value={edit.draft.name} onValue={(name) => edit.set({ name })} required maxLength={200} problem={edit.problemOf("name")} />
      <CheckField label="Archived" hint="No longer offered for new assignments; what was done stays." value={edit.draft.archived_ms > 0} onValue={(archived) => edit.set({ archived_ms: archived ? read.value.archived_ms || Date.now() : 0 })} />
      <EditNotices edit={edit} compared={kCompared} fields={["name"]} />
      <div><button type="submit" class="button primary" disabled={edit.busy || !edit.changed}>Save</button></div>
    </form>
  );
}

function Members({ client, cohort, admin, onChanged }: { readonly client: Client; readonly cohort: Cohort; readonly admin: boolean; readonly onChanged: () => void }) {
  const [leaving, setLeaving] = useState<CohortMember>();
  const sorted = [...cohort.members].sort((a, b) => a.role.localeCompare(b.role) || a.display_name.localeCompare(b.display_name, undefined, { numeric: true }));
  const name = (member: CohortMember) => admin ? <a href={`/people/${member.id}`}>{member.display_name}</a> : member.display_name;
  return (
    <Card title={`Members (${cohort.members.length})`}>
      {sorted.length === 0 ? <Empty>Nobody is in this cohort yet.</Empty> : (
        <DataTable label={`Members of ${cohort.name}`} items={sorted} rowKey={(member) => member.id} dense columns={[
          { title: "Name", cell: name },
          { title: "Role", cell: (member) => member.role },
          { title: "Attempts", cell: (member) => <a href={`/attempts?cohort=${cohort.id}&person=${member.id}`}>Attempts<span class="hidden"> of {member.display_name}</span></a> },
          ...(admin ? [{ title: "Remove", hideTitle: true, cell: (member: CohortMember) => (
            <div class="row-tools"><button type="button" class="button small" onClick={() => setLeaving(member)}>Remove…<span class="hidden"> {member.display_name}</span></button></div>) }] : []),
        ]} />
      )}
      {admin && cohort.archived_ms === 0 && <AddMember client={client} cohort={cohort} onAdded={onChanged} />}
      {leaving !== undefined && (
        <Confirm title={`Remove ${leaving.display_name} from ${cohort.name}?`} action="Remove" onClose={() => setLeaving(undefined)}
                 onConfirm={async () => {
                   const result = await client.people.removeMember(cohort.id, leaving.id);
                   if (!result.ok) return result.error.message;
                   onChanged();
                   return undefined;
                 }}>
          <p>The person keeps account, attempts and scores. {leaving.role === "instructor" ? "The instructor does not see this cohort any more." : "The cohort's assignments are not offered to the person any more."} You can add the person again.</p>
        </Confirm>
      )}
    </Card>
  );
}

// Found by name or login, because a school has many people.
function AddMember({ client, cohort, onAdded }: { readonly client: Client; readonly cohort: Cohort; readonly onAdded: () => void }) {
  const [text, setText] = useState("");
  const [asked, setAsked] = useState("");
  const found = useRequest(asked === "" ? undefined : asked, (signal) => client.people.list({ text: asked, limit: 20 }, signal));
  const change = useChange();
  const submit = (event: Event) => {
    event.preventDefault();
    setAsked(text.trim());
  };
  const inside = new Set(cohort.members.map((member) => member.id));
  const add = async (id: string) => {
    const result = await change.run(() => client.people.addMember(cohort.id, id));
    if (result?.ok === true) onAdded();
  };
  const items = found.loaded.state === "ready" ? found.loaded.value.items : [];
  return (
    <>
      <form class="filters" role="search" onSubmit={submit}>
        <TextField label="Add somebody: name or login" value={text} onValue={setText} maxLength={100} />
        <button type="submit" class="button" disabled={text.trim() === ""}>Find</button>
      </form>
      {change.error !== undefined && <ErrorNotice title="Not added" message={change.error.message} />}
      {asked !== "" && found.loaded.state === "failed" && <ErrorNotice title="People could not be searched" message={found.loaded.error.message} />}
      {asked !== "" && found.loaded.state === "ready" && (items.length === 0 ? <Empty>Nobody has that name.</Empty> : (
        <DataTable label="People found" items={items} rowKey={(person) => person.id} dense columns={[
          { title: "Name", cell: (person) => person.display_name },
          { title: "Login", cell: (person) => <code>{person.login}</code> },
          { title: "Role", cell: (person) => person.role },
          { title: "Add", hideTitle: true, cell: (person) => (
            <div class="row-tools">{inside.has(person.id) ? <span class="hint">Is a member</span>
              : <button type="button" class="button small" disabled={change.busy} onClick={() => void add(person.id)}>Add<span class="hidden"> {person.display_name}</span></button>}</div>) },
        ]} />
      ))}
    </>
  );
}
