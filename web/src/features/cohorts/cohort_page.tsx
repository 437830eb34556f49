import { useMemo, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { failed, type Tagged } from "../../api/http";
import type { Cohort, CohortMember } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useEdit } from "../../api/use_edit";
import { useRequest } from "../../api/use_request";
import { compareNames, namesIn } from "../../base/names";
import { say } from "../../base/words";
import { Badge, Brief, Card, Empty, ErrorNotice, PageTitle, Waits } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
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
  const { loaded, reload } = useRequest(id, (signal) => client.tagged("GET", "/cohorts/{id}", { id, signal }));
  if (loaded.state !== "ready")
    return (
      <Waits loaded={loaded} reload={reload} what={say("loading.cohort")} failed={say("cohort.failed")}>
        <PageTitle document={say("common.cohort")}>{say("common.cohort")}</PageTitle>
      </Waits>
    );
  const cohort = loaded.value.value;
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href="/cohorts">{say("nav.cohorts")}</a>
      </nav>
      <div class="title-row">
        <PageTitle document={cohort.name}>{cohort.name}</PageTitle>
        {cohort.archived_ms > 0 && <Badge tone="neutral">{say("cohort.archived")}</Badge>}
      </div>
      <p class="byline">
        <a href={`/attempts?cohort=${cohort.id}`}>{say("nav.attempts")}</a>
        {" · "}
        <a href={`/grading?cohort=${cohort.id}`}>{say("grading.title")}</a>
        {" · "}
        <a href={`/assignments?cohort=${cohort.id}`}>{say("nav.assignments")}</a>
      </p>
      <GradesCard client={client} cohort={cohort} />
      <div class={admin ? "columns" : ""}>
        <Members client={client} cohort={cohort} admin={admin} onChanged={reload} />
        {admin && (
          <Card title={say("cohort.details")}>
            <Details key={loaded.value.tag} client={client} read={loaded.value} onRead={reload} />
          </Card>
        )}
      </div>
    </>
  );
}

const compared = () => [
  {
    title: say("account.name"),
    text: (cohort: Cohort) => cohort.name,
  },
  {
    title: say("cohort.archived"),
    text: (cohort: Cohort) => (cohort.archived_ms > 0 ? "yes" : "no"),
  },
];

function Details({
  client,
  read,
  onRead,
}: {
  readonly client: Client;
  readonly read: Tagged<Cohort>;
  readonly onRead: () => void;
}) {
  const edit = useEdit(
    read,
    ({ name, archived_ms }, tag) =>
      client.tagged("PATCH", "/cohorts/{id}", {
        id: read.value.id,
        body: { name: name.trim(), archived: archived_ms > 0 },
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
        value={edit.draft.name}
        onValue={(name) => edit.set({ name })}
        required
        maxLength={200}
        problem={edit.problemOf("name")}
      />
      <CheckField
        label={say("cohort.archived")}
        hint={say("cohort.archived_hint")}
        value={edit.draft.archived_ms > 0}
        onValue={(archived) => edit.set({ archived_ms: archived ? read.value.archived_ms || Date.now() : 0 })}
      />
      <EditNotices edit={edit} compared={compared()} fields={["name"]} />
      <div>
        <Button busy={edit.busy} blocked={edit.changed ? undefined : say("rubric.nothing_changed")}>
          {say("common.save")}
        </Button>
      </div>
    </form>
  );
}

function Members({
  client,
  cohort,
  admin,
  onChanged,
}: {
  readonly client: Client;
  readonly cohort: Cohort;
  readonly admin: boolean;
  readonly onChanged: () => void;
}) {
  const [leaving, setLeaving] = useState<CohortMember>();
  const sorted = useMemo(
    () =>
      [...cohort.members].sort((a, b) => a.role.localeCompare(b.role) || compareNames(a.display_name, b.display_name)),
    [cohort.members],
  );
  const named = namesIn(sorted);
  const name = (member: CohortMember) => (admin ? <a href={`/people/${member.id}`}>{named(member)}</a> : named(member));
  return (
    <Card title={say("cohort.members", { count: cohort.members.length })}>
      {sorted.length === 0 ? (
        <Empty>{say("cohort.nobody")}</Empty>
      ) : (
        <DataTable
          label={say("cohort.members_of", { name: cohort.name })}
          items={sorted}
          rowKey={(member) => member.id}
          dense
          columns={[
            { title: say("account.name"), cell: name },
            { title: say("account.role"), cell: (member) => say(`role.${member.role}`) },
            {
              title: say("nav.attempts"),
              cell: (member) => (
                <a href={`/attempts?cohort=${cohort.id}&person=${member.id}`}>
                  <Brief shown={say("nav.attempts")} full={say("cohort.attempts_of", { name: named(member) })} />
                </a>
              ),
            },
            ...(admin
              ? [
                  {
                    title: say("common.remove"),
                    hideTitle: true,
                    cell: (member: CohortMember) => (
                      <div class="row-tools">
                        <button type="button" class="button small" onClick={() => setLeaving(member)}>
                          <Brief
                            shown={say("cohort.remove_ask")}
                            full={say("cohort.remove_whom", { name: named(member) })}
                          />
                        </button>
                      </div>
                    ),
                  },
                ]
              : []),
          ]}
        />
      )}
      {admin && cohort.archived_ms === 0 && <AddMember client={client} cohort={cohort} onAdded={onChanged} />}
      {leaving !== undefined && (
        <Confirm
          title={say("cohort.remove_title", { name: leaving.display_name, cohort: cohort.name })}
          action={say("common.remove")}
          onClose={() => setLeaving(undefined)}
          onConfirm={() =>
            failed(client.post("/cohorts/{id}/members", { id: cohort.id, body: { remove: [leaving.id] } }), onChanged)
          }
        >
          <p>{leaving.role === "instructor" ? say("cohort.remove_instructor") : say("cohort.remove_student")}</p>
        </Confirm>
      )}
    </Card>
  );
}

// Found by name or login, because a school has many people.
function AddMember({
  client,
  cohort,
  onAdded,
}: {
  readonly client: Client;
  readonly cohort: Cohort;
  readonly onAdded: () => void;
}) {
  const [text, setText] = useState("");
  const [asked, setAsked] = useState("");
  const found = useRequest(asked === "" ? undefined : asked, (signal) =>
    client.page("/people", { text: asked, limit: 20, signal }),
  );
  const change = useChange();
  const submit = (event: Event) => {
    event.preventDefault();
    setAsked(text.trim());
  };
  const inside = new Set(cohort.members.map((member) => member.id));
  const add = async (id: string) => {
    const result = await change.run(() => client.post("/cohorts/{id}/members", { id: cohort.id, body: { add: [id] } }));
    if (result?.ok === true) onAdded();
  };
  const items = found.loaded.state === "ready" ? found.loaded.value.items : [];
  return (
    <>
      <form class="filters" role="search" onSubmit={submit}>
        <TextField label={say("cohort.add")} value={text} onValue={setText} maxLength={100} />
        <Button kind="" blocked={needed({ [say("account.name")]: text.trim() })}>
          {say("common.find")}
        </Button>
      </form>
      {change.error !== undefined && <ErrorNotice title={say("common.not_added")} message={change.error.message} />}
      {asked !== "" && found.loaded.state === "failed" && (
        <ErrorNotice title={say("cohort.search_failed")} message={found.loaded.error.message} />
      )}
      {asked !== "" &&
        found.loaded.state === "ready" &&
        (items.length === 0 ? (
          <Empty>{say("common.nobody_named")}</Empty>
        ) : (
          <DataTable
            label={say("cohort.found")}
            items={items}
            rowKey={(person) => person.id}
            dense
            columns={[
              { title: say("account.name"), cell: (person) => person.display_name },
              { title: say("account.login"), cell: (person) => <code>{person.login}</code> },
              { title: say("account.role"), cell: (person) => say(`role.${person.role}`) },
              {
                title: say("common.add"),
                hideTitle: true,
                cell: (person) => (
                  <div class="row-tools">
                    {inside.has(person.id) ? (
                      <span class="hint">{say("cohort.is_member")}</span>
                    ) : (
                      <button
                        type="button"
                        class="button small"
                        disabled={change.busy}
                        onClick={() => void add(person.id)}
                      >
                        <Brief shown={say("common.add")} full={say("cohort.add_whom", { name: person.display_name })} />
                      </button>
                    )}
                  </div>
                ),
              },
            ]}
          />
        ))}
    </>
  );
}
