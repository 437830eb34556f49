import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Tagged } from "../../api/http";
import type { PersonDetail, PersonWithCohorts } from "../../api/types";
import { useEdit } from "../../api/use_edit";
import { useRequest } from "../../api/use_request";
import { Card, ErrorNotice, Loading, PageTitle } from "../../widgets/basics";
import { Confirm, Dialog } from "../../widgets/dialog";
import { EditNotices } from "../../widgets/edit_notices";
import { CheckField, SelectField, TextField } from "../../widgets/form";
import { SessionsTable } from "../../widgets/sessions_table";
import { OneTimePassword } from "./one_time_password";
import { kRoles, PersonState } from "./people_page";

interface Props {
  readonly client: Client;
  readonly id: string;
  readonly self: boolean;                       // the admin's own account
  readonly onGone: () => void;
}

export function PersonPage({ client, id, self, onGone }: Props) {
  const { loaded, reload } = useRequest(id, (signal) => client.people.get(id, signal));
  return (
    <>
      <nav class="trail" aria-label="Where you are"><a href="/people">People</a></nav>
      {loaded.state === "loading" && <Loading what="the person" />}
      {loaded.state === "failed" && (
        <><PageTitle document="Person">Person</PageTitle><ErrorNotice title="The person could not be loaded" message={loaded.error.message} onRetry={reload} /></>
      )}
      {loaded.state === "ready" && <LoadedPerson key={loaded.value.tag} client={client} read={loaded.value} self={self} onChanged={reload} onGone={onGone} />}
    </>
  );
}

function LoadedPerson({ client, read, self, onChanged, onGone }:
    { readonly client: Client; readonly read: Tagged<PersonWithCohorts>; readonly self: boolean; readonly onChanged: () => void; readonly onGone: () => void }) {
  const [latest, setLatest] = useState<Tagged<PersonDetail>>(read);
  const person = latest.value;
  return (
    <>
      <div class="title-row"><PageTitle document={person.display_name}>{person.display_name}</PageTitle><PersonState person={person} /></div>
      <p class="byline">Login <code>{person.login}</code>{" · "}<a href={`/attempts?person=${person.id}`}>Attempts</a>{" · "}<a href={`/audit?object=${person.id}`}>Audit</a>
        {read.value.cohorts.map((cohort) => <span key={cohort.id}>{" · "}<a href={`/cohorts/${cohort.id}`}>{cohort.name}</a></span>)}
      </p>
      <div class="columns">
        <Card title="Details"><Details client={client} read={read} self={self} onRead={setLatest} /></Card>
        <Card title="Access"><Access client={client} read={latest} self={self} onChanged={onChanged} /></Card>
      </div>
      <PersonSessions client={client} person={person} />
      {!self && <Erase client={client} person={person} onGone={onGone} />}
    </>
  );
}

const kCompared = [
  { title: "Name", text: (person: PersonDetail) => person.display_name },
  { title: "Role", text: (person: PersonDetail) => person.role as string },
  { title: "Disabled", text: (person: PersonDetail) => person.disabled ? "yes" : "no" },
];

function Details({ client, read, self, onRead }:
    { readonly client: Client; readonly read: Tagged<PersonDetail>; readonly self: boolean; readonly onRead: (read: Tagged<PersonDetail>) => void }) {
  const edit = useEdit(read, ({ display_name, role }, tag) => client.people.edit(read.value.id, { display_name: display_name.trim(), role }, tag), onRead);
  const submit = (event: Event) => {
    event.preventDefault();
    void edit.save();
  };
  return (
    <form class="form" onSubmit={submit}>
      <TextField label="Name" value={edit.draft.display_name} onValue={(name) => edit.set({ display_name: name })} required maxLength={200} problem={edit.problemOf("display_name")} />
      <SelectField label="Role" value={edit.draft.role} onValue={(role) => edit.set({ role })} options={kRoles} problem={edit.problemOf("role")}
                   {...(self ? { hint: "This is your own account: without the admin role you cannot come back to this screen." } : {})} />
      <EditNotices edit={edit} compared={kCompared} fields={["display_name", "role"]} />
      <div><button type="submit" class="button primary" disabled={edit.busy || !edit.changed}>Save</button></div>
    </form>
  );
}

function Access({ client, read, self, onChanged }:
    { readonly client: Client; readonly read: Tagged<PersonDetail>; readonly self: boolean; readonly onChanged: () => void }) {
  const person = read.value;
  const [open, setOpen] = useState<"reset" | "disable">();
  const [made, setMade] = useState<{ readonly password: string; readonly untilMs: number }>();
  const close = () => setOpen(undefined);
  const setDisabled = async (disabled: boolean) => {
    const result = await client.people.edit(person.id, { disabled }, read.tag);
    if (!result.ok) return result.error.message;
    onChanged();
    return undefined;
  };
  const reset = async () => {
    const result = await client.people.resetPassword(person.id);
    if (!result.ok) return result.error.message;
    setMade({ password: result.value.password, untilMs: result.value.password_until_ms });
    return undefined;
  };
  return (
    <>
      <div class="button-row">
        <button type="button" class="button" onClick={() => setOpen("reset")}>Reset the password…</button>
        {!self && <button type="button" class="button" onClick={() => setOpen("disable")}>{person.disabled ? "Enable again…" : "Disable…"}</button>}
      </div>
      <p class="hint">Disabling signs the person out everywhere within seconds and refuses every sign-in. Attempts and scores stay.</p>
      {open === "reset" && (
        <Confirm title={`Reset the password of ${person.display_name}?`} action="Reset the password" onClose={close} onConfirm={reset}>
          <p>The current password stops working, and every session ends. You get a new one to hand over.</p>
        </Confirm>
      )}
      {open === "disable" && (
        <Confirm title={person.disabled ? `Enable ${person.display_name} again?` : `Disable ${person.display_name}?`} tone={person.disabled ? "neutral" : "bad"}
                 action={person.disabled ? "Enable" : "Disable"} onClose={close} onConfirm={() => setDisabled(!person.disabled)}>
          <p>{person.disabled ? "The person can sign in again with the old password." : "The person is signed out everywhere and cannot sign in. You can enable the account again at any time."}</p>
        </Confirm>
      )}
      {made !== undefined && (
        <Dialog title="New password" onClose={() => { setMade(undefined); onChanged(); }}>
          <OneTimePassword login={person.login} {...made} onClose={() => { setMade(undefined); onChanged(); }} />
        </Dialog>
      )}
    </>
  );
}

function PersonSessions({ client, person }: { readonly client: Client; readonly person: PersonDetail }) {
  const { loaded, reload } = useRequest(person.id, (signal) => client.people.sessions(person.id, signal));
  const sessions = loaded.state === "ready" ? loaded.value : [];
  const [endingAll, setEndingAll] = useState(false);
  return (
    <Card title="Signed in" {...(sessions.length === 0 ? {} : { aside: <button type="button" class="button small" onClick={() => setEndingAll(true)}>End all…</button> })}>
      {loaded.state === "loading" && <Loading what="sessions" />}
      {loaded.state === "failed" && <ErrorNotice title="The sessions could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (
        <SessionsTable sessions={sessions} label={`Sessions of ${person.display_name}`}
                       onEnd={async (session) => {
                         const result = await client.people.endSession(session);
                         if (!result.ok) return result.error.message;
                         reload();
                         return undefined;
                       }} />
      )}
      {endingAll && (
        <Confirm title={`Sign ${person.display_name} out everywhere?`} action="End all sessions" onClose={() => setEndingAll(false)}
                 onConfirm={async () => {
                   const result = await client.people.endSessions(person.id);
                   if (!result.ok) return result.error.message;
                   reload();
                   return undefined;
                 }}>
          <p>The page and the stations ask for the password again. An attempt that is being recorded goes on.</p>
        </Confirm>
      )}
    </Card>
  );
}

// Ends everything that is kept about a person (schemas/personal_data.md).
function Erase({ client, person, onGone }: { readonly client: Client; readonly person: PersonDetail; readonly onGone: () => void }) {
  const [open, setOpen] = useState(false);
  const [login, setLogin] = useState("");
  const [withReferences, setWithReferences] = useState(false);
  return (
    <Card title="Erase">
      <p>Removes name, login, sessions, attempts and recordings of this person for ever. For everything else, disable the account instead.</p>
      <button type="button" class="button" onClick={() => setOpen(true)}>Erase this person…</button>
      {open && (
        <Confirm title={`Erase ${person.display_name}?`} action="Erase for ever" onClose={() => setOpen(false)}
                 onConfirm={async () => {
                   const result = await client.people.erase(person.id, login.trim(), withReferences);
                   if (!result.ok) return result.error.message;
                   onGone();
                   return undefined;
                 }}>
          <p>This cannot be undone, and a backup that is restored forgets the person again.</p>
          <TextField label={`Type the login (${person.login}) to confirm`} value={login} onValue={setLogin} maxLength={64} />
          <CheckField label="Also reference cuts of this person" hint="Without it, a person whose cut is a reference is not erased." value={withReferences} onValue={setWithReferences} />
        </Confirm>
      )}
    </Card>
  );
}
