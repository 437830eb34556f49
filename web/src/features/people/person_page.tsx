import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { failed, type Tagged } from "../../api/http";
import type { Mentions, PersonDetail, PersonWithCohorts } from "../../api/types";
import { useEdit } from "../../api/use_edit";
import { useRequest } from "../../api/use_request";
import { say, sayWith } from "../../base/words";
import { Card, ErrorNotice, Loading, PageTitle, Waits } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { Confirm, Dialog } from "../../widgets/dialog";
import { EditNotices } from "../../widgets/edit_notices";
import { CheckField, SelectField, TextField } from "../../widgets/form";
import { SessionsTable } from "../../widgets/sessions_table";
import { OneTimePassword } from "./one_time_password";
import { PersonState, roles } from "./people_page";

interface Props {
  readonly client: Client;
  readonly id: string;
  readonly self: boolean; // the admin's own account
  readonly onGone: () => void;
}

export function PersonPage({ client, id, self, onGone }: Props) {
  const { loaded, reload } = useRequest(id, (signal) => client.tagged("GET", "/people/{id}", { id, signal }));
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href="/people">{say("nav.people")}</a>
      </nav>
      {loaded.state === "loading" && <Loading what={say("loading.person")} />}
      {loaded.state === "failed" && (
        <>
          <PageTitle document={say("person.one")}>{say("person.one")}</PageTitle>
          <ErrorNotice title={say("person.failed")} message={loaded.error.message} onRetry={reload} />
        </>
      )}
      {loaded.state === "ready" && (
        <LoadedPerson
          key={loaded.value.tag}
          client={client}
          read={loaded.value}
          self={self}
          onChanged={reload}
          onGone={onGone}
        />
      )}
    </>
  );
}

function LoadedPerson({
  client,
  read,
  self,
  onChanged,
  onGone,
}: {
  readonly client: Client;
  readonly read: Tagged<PersonWithCohorts>;
  readonly self: boolean;
  readonly onChanged: () => void;
  readonly onGone: () => void;
}) {
  const [latest, setLatest] = useState<Tagged<PersonDetail>>(read);
  const person = latest.value;
  return (
    <>
      <div class="title-row">
        <PageTitle document={person.display_name}>{person.display_name}</PageTitle>
        <PersonState person={person} />
      </div>
      <p class="byline">
        {sayWith("person.login", { login: <code>{person.login}</code> })}
        {" · "}
        <a href={`/attempts?person=${person.id}`}>{say("nav.attempts")}</a>
        {" · "}
        <a href={`/audit?object=${person.id}`}>{say("nav.audit")}</a>
        {read.value.cohorts.map((cohort) => (
          <span key={cohort.id}>
            {" · "}
            <a href={`/cohorts/${cohort.id}`}>{cohort.name}</a>
          </span>
        ))}
      </p>
      <div class="columns">
        <Card title={say("cohort.details")}>
          <Details client={client} read={read} self={self} onRead={setLatest} />
        </Card>
        <Card title={say("person.access")}>
          <Access client={client} read={latest} self={self} onChanged={onChanged} />
        </Card>
      </div>
      <PersonSessions client={client} person={person} />
      {!self && <Erase client={client} person={person} onGone={onGone} />}
    </>
  );
}

const compared = () => [
  {
    title: say("account.name"),
    text: (person: PersonDetail) => person.display_name,
  },
  {
    title: say("account.role"),
    text: (person: PersonDetail) => person.role as string,
  },
  {
    title: say("people.disabled"),
    text: (person: PersonDetail) => (person.disabled ? "yes" : "no"),
  },
  {
    title: say("person.may_import_teeth"),
    text: (person: PersonDetail) => (person.may_import_teeth ? "yes" : "no"),
  },
];

function Details({
  client,
  read,
  self,
  onRead,
}: {
  readonly client: Client;
  readonly read: Tagged<PersonDetail>;
  readonly self: boolean;
  readonly onRead: (read: Tagged<PersonDetail>) => void;
}) {
  const edit = useEdit(
    read,
    ({ display_name, role, may_import_teeth }, tag) =>
      client.tagged("PATCH", "/people/{id}", {
        id: read.value.id,
        body: { display_name: display_name.trim(), role, may_import_teeth },
        tag,
      }),
    onRead,
  );
  const submit = (event: Event) => {
    event.preventDefault();
    void edit.save();
  };
  return (
    <form class="form" onSubmit={submit}>
      <TextField
        label={say("account.name")}
        value={edit.draft.display_name}
        onValue={(name) => edit.set({ display_name: name })}
        required
        maxLength={200}
        problem={edit.problemOf("display_name")}
      />
      <SelectField
        label={say("account.role")}
        value={edit.draft.role}
        onValue={(role) => edit.set({ role })}
        options={roles()}
        problem={edit.problemOf("role")}
        {...(self ? { hint: say("person.own_account") } : {})}
      />
      {edit.draft.role === "instructor" && (
        <CheckField
          label={say("person.may_import_teeth")}
          hint={say("person.may_import_teeth_hint")}
          value={edit.draft.may_import_teeth}
          onValue={(may) => edit.set({ may_import_teeth: may })}
        />
      )}
      <EditNotices edit={edit} compared={compared()} fields={["display_name", "role", "may_import_teeth"]} />
      <div>
        <Button busy={edit.busy} blocked={edit.changed ? undefined : say("rubric.nothing_changed")}>
          {say("common.save")}
        </Button>
      </div>
    </form>
  );
}

function Access({
  client,
  read,
  self,
  onChanged,
}: {
  readonly client: Client;
  readonly read: Tagged<PersonDetail>;
  readonly self: boolean;
  readonly onChanged: () => void;
}) {
  const person = read.value;
  const [open, setOpen] = useState<"reset" | "disable">();
  const [made, setMade] = useState<{ readonly password: string; readonly untilMs: number }>();
  const close = () => setOpen(undefined);
  const setDisabled = (disabled: boolean) =>
    failed(client.patch("/people/{id}", { id: person.id, body: { disabled }, tag: read.tag }), onChanged);
  const reset = () =>
    failed(client.post("/people/{id}/password", { id: person.id }), (done) =>
      setMade({ password: done.password, untilMs: done.password_until_ms }),
    );
  return (
    <>
      <div class="button-row">
        <button type="button" class="button" onClick={() => setOpen("reset")}>
          {say("person.reset_ask")}
        </button>
        {!self && (
          <button type="button" class="button" onClick={() => setOpen("disable")}>
            {person.disabled ? say("person.enable_ask") : say("person.disable_ask")}
          </button>
        )}
      </div>
      <p class="hint">{say("person.disable_hint")}</p>
      {open === "reset" && (
        <Confirm
          title={say("person.reset_title", { name: person.display_name })}
          action={say("person.reset")}
          onClose={close}
          onConfirm={reset}
        >
          <p>{say("person.reset_text")}</p>
        </Confirm>
      )}
      {open === "disable" && (
        <Confirm
          title={
            person.disabled
              ? say("person.enable_title", { name: person.display_name })
              : say("person.disable_title", { name: person.display_name })
          }
          tone={person.disabled ? "neutral" : "bad"}
          action={person.disabled ? say("person.enable") : say("person.disable")}
          onClose={close}
          onConfirm={() => setDisabled(!person.disabled)}
        >
          <p>{person.disabled ? say("person.enable_text") : say("person.disable_text")}</p>
        </Confirm>
      )}
      {made !== undefined && (
        <Dialog
          title={say("account.new_password")}
          onClose={() => {
            setMade(undefined);
            onChanged();
          }}
        >
          <OneTimePassword
            login={person.login}
            {...made}
            onClose={() => {
              setMade(undefined);
              onChanged();
            }}
          />
        </Dialog>
      )}
    </>
  );
}

function PersonSessions({ client, person }: { readonly client: Client; readonly person: PersonDetail }) {
  const { loaded, reload } = useRequest(person.id, (signal) =>
    client.all("/people/{id}/sessions", { id: person.id, signal }),
  );
  const sessions = loaded.state === "ready" ? loaded.value : [];
  const [endingAll, setEndingAll] = useState(false);
  return (
    <Card
      title={say("person.signed_in")}
      {...(sessions.length === 0
        ? {}
        : {
            aside: (
              <button type="button" class="button small" onClick={() => setEndingAll(true)}>
                {say("person.end_all_ask")}
              </button>
            ),
          })}
    >
      <Waits loaded={loaded} reload={reload} what={say("loading.sessions")} failed={say("person.sessions_failed")} />
      {loaded.state === "ready" && (
        <SessionsTable
          sessions={sessions}
          label={say("person.sessions_of", { name: person.display_name })}
          onEnd={(session) => failed(client.delete("/sessions/{id}", { id: session }), reload)}
        />
      )}
      {endingAll && (
        <Confirm
          title={say("person.end_all_title", { name: person.display_name })}
          action={say("person.end_all")}
          onClose={() => setEndingAll(false)}
          onConfirm={() => failed(client.delete("/people/{id}/sessions", { id: person.id }), reload)}
        >
          <p>{say("person.end_all_text")}</p>
        </Confirm>
      )}
    </Card>
  );
}

// Where each kind of place is edited; the others have no page of their own.
const kPageOf: Partial<Record<Mentions["kind"], string>> = {
  attempt: "/attempts",
  reference: "/attempts",
  exercise: "/exercises",
  cohort: "/cohorts",
};

// Where the name of somebody erased is still in what people typed.
function Left({
  name,
  mentions,
  onRead,
}: {
  readonly name: string;
  readonly mentions: readonly Mentions[];
  readonly onRead: () => void;
}) {
  return (
    <Card title={say("person.erased", { name })}>
      <p>{say("person.mentions")}</p>
      <ul>
        {mentions.map(({ kind, count, places }) => (
          <li key={kind}>
            {say(`person.mention_${kind}`)}: {count}{" "}
            {places.map((place, i) => (
              <a
                key={place}
                href={`${kPageOf[kind]}/${place}`}
                aria-label={`${say(`person.mention_${kind}`)} ${i + 1}`}
              >
                {i + 1}{" "}
              </a>
            ))}
          </li>
        ))}
      </ul>
      <button type="button" class="button" onClick={onRead}>
        {say("person.mentions_read")}
      </button>
    </Card>
  );
}

// Ends everything that is kept about a person (schemas/personal_data.md).
function Erase({
  client,
  person,
  onGone,
}: {
  readonly client: Client;
  readonly person: PersonDetail;
  readonly onGone: () => void;
}) {
  const [open, setOpen] = useState(false);
  const [login, setLogin] = useState("");
  const [withReferences, setWithReferences] = useState(false);
  const [left, setLeft] = useState<readonly Mentions[]>([]);
  if (left.length > 0) return <Left name={person.display_name} mentions={left} onRead={onGone} />;
  return (
    <Card title={say("person.erase")}>
      <p>{say("person.erase_hint")}</p>
      <button type="button" class="button" onClick={() => setOpen(true)}>
        {say("person.erase_ask")}
      </button>
      {open && (
        <Confirm
          title={say("person.erase_title", { name: person.display_name })}
          action={say("person.erase_for_ever")}
          onClose={() => setOpen(false)}
          onConfirm={async () => {
            const result = await client.post("/people/{id}/erase", {
              id: person.id,
              body: { login: login.trim(), with_references: withReferences },
            });
            if (!result.ok) return result.error.message;
            if (result.value.mentions.length === 0) onGone();
            setOpen(false);
            setLeft(result.value.mentions);
            return undefined;
          }}
        >
          <p>{say("person.erase_text")}</p>
          <TextField
            label={say("person.type_login", { login: person.login })}
            value={login}
            onValue={setLogin}
            maxLength={64}
          />
          <CheckField
            label={say("person.erase_references")}
            hint={say("person.erase_references_hint")}
            value={withReferences}
            onValue={setWithReferences}
          />
        </Confirm>
      )}
    </Card>
  );
}
