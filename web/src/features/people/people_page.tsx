import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { PersonDetail, Role } from "../../api/types";
import { useChange } from "../../api/use_change";
import { usePages } from "../../api/use_pages";
import { useRequest } from "../../api/use_request";
import { say } from "../../base/words";
import { Badge, Card, ErrorNotice, PageTitle } from "../../widgets/basics";
import { Dialog, FormButtons } from "../../widgets/dialog";
import { SelectField, TextField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { DataTable } from "../../widgets/table";
import { OneTimePassword } from "./one_time_password";

const kPageSize = 50;
export const roles = () =>
  (["student", "instructor", "admin"] as const).map((value) => ({ value, title: roleTitle(value) }));
const roleTitle = (role: Role) => say(`people.${role}`);

interface Props {
  readonly client: Client;
  readonly query: URLSearchParams;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
}

export function PeoplePage({ client, query, onQuery }: Props) {
  const filter = {
    text: query.get("text") ?? "",
    role: (query.get("role") ?? "") as Role,
    cohort: query.get("cohort") ?? "",
  };
  const pages = usePages(JSON.stringify(filter), (cursor, signal) =>
    client.page("/people", { ...filter, cursor, limit: kPageSize, signal }),
  );
  const [adding, setAdding] = useState(false);
  return (
    <>
      <div class="toolbar">
        <PageTitle document={say("nav.people")}>{say("nav.people")}</PageTitle>
        <div class="button-row">
          <a class="button" href="/roster">
            {say("people.import_ask")}
          </a>
          <button type="button" class="button primary" onClick={() => setAdding(true)}>
            {say("people.add_ask")}
          </button>
        </div>
      </div>
      <Filters client={client} filter={filter} onQuery={onQuery} />
      <PagedList pages={pages} list="people" empty={say("people.none")}>
        {(people) => (
          <Card className="flush">
            <DataTable label={say("nav.people")} items={people} rowKey={(person) => person.id} columns={columns()} />
          </Card>
        )}
      </PagedList>
      {adding && <AddPerson client={client} onClose={() => setAdding(false)} onAdded={pages.reload} />}
    </>
  );
}

const columns = () => [
  {
    title: say("account.name"),
    cell: (person: PersonDetail) => <a href={`/people/${person.id}`}>{person.display_name}</a>,
  },
  {
    title: say("account.login"),
    cell: (person: PersonDetail) => <code>{person.login}</code>,
  },
  {
    title: say("account.role"),
    cell: (person: PersonDetail) => roleTitle(person.role),
  },
  {
    title: say("common.state"),
    cell: (person: PersonDetail) => <PersonState person={person} />,
  },
];

export function PersonState({ person }: { readonly person: PersonDetail }) {
  if (person.disabled) return <Badge tone="bad">{say("people.disabled")}</Badge>;
  return person.must_change_password ? (
    <Badge tone="warning">{say("people.one_time")}</Badge>
  ) : (
    <Badge tone="good">{say("people.active")}</Badge>
  );
}

function Filters({
  client,
  filter,
  onQuery,
}: Omit<Props, "query"> & {
  readonly filter: { readonly text: string; readonly role: Role; readonly cohort: string };
}) {
  const cohorts = useRequest("cohorts", (signal) => client.all("/cohorts", { signal }));
  const [text, setText] = useState(filter.text);
  const names = cohorts.loaded.state === "ready" ? cohorts.loaded.value : [];
  const submit = (event: Event) => {
    event.preventDefault();
    onQuery({ ...filter, text: text.trim() });
  };
  return (
    <form class="filters" role="search" onSubmit={submit}>
      <TextField label={say("people.name_or_login")} value={text} onValue={setText} maxLength={100} />
      <SelectField
        label={say("account.role")}
        value={filter.role}
        onValue={(role) => onQuery({ ...filter, role })}
        options={[{ value: "", title: say("common.any") }, ...roles()]}
      />
      <SelectField
        label={say("common.cohort")}
        value={filter.cohort}
        onValue={(cohort) => onQuery({ ...filter, cohort })}
        options={[
          { value: "", title: say("common.any") },
          ...names.map((cohort) => ({ value: cohort.id, title: cohort.name })),
        ]}
      />
      <button type="submit" class="button">
        {say("people.search")}
      </button>
    </form>
  );
}

function AddPerson({
  client,
  onClose,
  onAdded,
}: {
  readonly client: Client;
  readonly onClose: () => void;
  readonly onAdded: () => void;
}) {
  const [login, setLogin] = useState("");
  const [name, setName] = useState("");
  const [role, setRole] = useState<Role>("student");
  const [made, setMade] = useState<{ readonly login: string; readonly password: string; readonly untilMs: number }>();
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() =>
      client.post("/people", { body: { login: login.trim(), display_name: name.trim(), role } }),
    );
    if (result?.ok !== true) return;
    setMade({ login: result.value.login, password: result.value.password, untilMs: result.value.password_until_ms });
    onAdded();
  };
  const problem = (field: string) => (change.error?.field === field ? change.error.message : undefined);
  if (made !== undefined) {
    return (
      <Dialog title={say("people.added")} onClose={onClose}>
        <OneTimePassword {...made} onClose={onClose} />
      </Dialog>
    );
  }
  return (
    <Dialog title={say("people.add")} onClose={onClose}>
      <form class="form" onSubmit={(event) => void submit(event)}>
        <TextField
          label={say("account.name")}
          value={name}
          onValue={setName}
          required
          maxLength={200}
          problem={problem("display_name")}
        />
        <TextField
          label={say("account.login")}
          value={login}
          onValue={setLogin}
          required
          maxLength={64}
          problem={problem("login")}
          hint={say("people.login_hint")}
        />
        <SelectField
          label={say("account.role")}
          value={role}
          onValue={setRole}
          options={roles()}
          problem={problem("role")}
        />
        {change.error !== undefined && !["login", "display_name", "role"].includes(change.error.field) && (
          <ErrorNotice title={say("common.not_added")} message={change.error.message} />
        )}
        <FormButtons action={say("common.add")} busy={change.busy} onCancel={onClose} />
      </form>
    </Dialog>
  );
}
