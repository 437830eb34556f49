import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { failed } from "../../api/http";
import type { Assignment, MarkingSummary, Person } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime } from "../../base/format";
import { ok } from "../../base/result";
import { say } from "../../base/words";
import { Card, Waits } from "../../widgets/basics";
import { Confirm } from "../../widgets/dialog";
import { CheckField } from "../../widgets/form";
import { DataTable } from "../../widgets/table";
import { progressText } from "./how_far";

interface Props {
  readonly client: Client;
  readonly assignment: Assignment;
  readonly self: Person;
}

// Blind markings of an assignment's attempts: those that there are, and a new one.
export function MarkingCard({ client, assignment, self }: Props) {
  const { loaded, reload } = useRequest(assignment.id, (signal) =>
    client.all("/assignments/{id}/markings", { id: assignment.id, signal }),
  );
  const [open, setOpen] = useState<"begin" | { readonly marking: MarkingSummary; readonly to: "give_up" | "change" }>();
  const close = () => setOpen(undefined);
  const markings = loaded.state === "ready" ? loaded.value : [];
  const underWay = markings.some((marking) => !marking.done && marking.ended_ms === 0);
  return (
    <Card title={say("marking.title")}>
      <p class="hint">{say("marking.card_hint")}</p>
      <Waits loaded={loaded} reload={reload} what={say("loading.markings")} failed={say("marking.list_failed")} />
      {markings.length > 0 && (
        <DataTable
          label={say("marking.title")}
          items={markings}
          rowKey={({ id }) => id}
          columns={[
            {
              title: say("marking.when"),
              cell: ({ id, created_ms: when }) => <a href={`/markings/${id}`}>{formatDateTime(when)}</a>,
            },
            { title: say("marking.how_far"), cell: howFar },
            {
              title: say("marking.give_up"),
              hideTitle: true,
              cell: (marking) =>
                marking.done || marking.ended_ms > 0 ? null : (
                  <div class="row-tools">
                    <button type="button" class="button small" onClick={() => setOpen({ marking, to: "change" })}>
                      {say("marking.change_ask")}
                    </button>
                    <button type="button" class="button small" onClick={() => setOpen({ marking, to: "give_up" })}>
                      {say("marking.give_up_ask")}
                    </button>
                  </div>
                ),
            },
          ]}
        />
      )}
      {loaded.state === "ready" && !underWay && (
        <div class="button-row">
          <button type="button" class="button" onClick={() => setOpen("begin")}>
            {say("marking.begin_ask")}
          </button>
        </div>
      )}
      {open === "begin" && (
        <ChooseMarkers client={client} assignment={assignment} self={self} onClose={close} onDone={reload} />
      )}
      {open !== undefined && open !== "begin" && open.to === "change" && (
        <ChooseMarkers
          client={client}
          assignment={assignment}
          self={self}
          marking={open.marking}
          onClose={close}
          onDone={reload}
        />
      )}
      {open !== undefined && open !== "begin" && open.to === "give_up" && (
        <Confirm
          title={say("marking.give_up_title")}
          action={say("marking.give_up")}
          onClose={close}
          onConfirm={() => failed(client.delete("/markings/{id}", { id: open.marking.id }), reload)}
        >
          <p>{say("marking.give_up_text")}</p>
        </Confirm>
      )}
    </Card>
  );
}

function howFar({ markers, works, done, ended_ms: ended }: MarkingSummary): string {
  if (done) return say("marking.done");
  if (ended > 0) return say("marking.given_up");
  return markers.map((marker) => progressText(marker, works)).join(" · ");
}

type Candidate = Pick<Person, "id" | "display_name">;

// Instructors of the cohort, whoever asks, and, for admins, every other instructor.
async function candidates(client: Client, { cohort }: Assignment, self: Person, signal: AbortSignal) {
  const found = new Map<string, Candidate>([[self.id, self]]);
  if (cohort !== null) {
    const read = await client.tagged("GET", "/cohorts/{id}", { id: cohort.id, signal });
    if (!read.ok) return read;
    for (const member of read.value.value.members) if (member.role !== "student") found.set(member.id, member);
  }
  if (self.role === "admin") {
    const read = await client.page("/people", { role: "instructor", limit: 200, signal });
    if (!read.ok) return read;
    for (const person of read.value.items) if (!person.disabled) found.set(person.id, person);
  }
  return ok([...found.values()].sort((a, b) => a.display_name.localeCompare(b.display_name)));
}

interface ChooseProps extends Props {
  readonly marking?: MarkingSummary; // under way; none: a new one
  readonly onClose: () => void;
  readonly onDone: () => void;
}

// Nobody is chosen unasked, not even the person who begins it.
function ChooseMarkers({ client, assignment, self, marking, onClose, onDone }: ChooseProps) {
  const { loaded, reload } = useRequest(assignment.id, (signal) => candidates(client, assignment, self, signal));
  const [chosen, setChosen] = useState<readonly string[]>(marking?.markers.map(({ id }) => id) ?? []);
  const people = loaded.state === "ready" ? withMarkers(loaded.value, marking) : [];
  return (
    <Confirm
      title={say(marking === undefined ? "marking.begin_title" : "marking.change_title")}
      action={say(marking === undefined ? "marking.begin" : "common.save")}
      tone="neutral"
      onClose={onClose}
      onConfirm={async () => {
        if (chosen.length < 2) return say("marking.two_at_least");
        return failed(
          marking === undefined
            ? client.post("/assignments/{id}/markings", { id: assignment.id, body: { marker_ids: chosen } })
            : client.put("/markings/{id}/markers", { id: marking.id, body: { marker_ids: chosen } }),
          onDone,
        );
      }}
    >
      <p>{say(marking === undefined ? "marking.begin_text" : "marking.change_text")}</p>
      <Waits loaded={loaded} reload={reload} what={say("loading.short")} failed={say("marking.no_people")} />
      {loaded.state === "ready" && (
        <fieldset class="form">
          <legend>{say("marking.who")}</legend>
          {people.map(({ id, display_name: name }) => (
            <CheckField
              key={id}
              label={name === "" ? say("marking.nobody") : name}
              value={chosen.includes(id)}
              onValue={(on) => setChosen(on ? [...chosen, id] : chosen.filter((each) => each !== id))}
            />
          ))}
          {people.length < 2 && <p class="hint">{say("marking.nobody_else")}</p>}
        </fieldset>
      )}
    </Confirm>
  );
}

// A marker may teach another cohort, where an admin chose them.
function withMarkers(people: readonly Candidate[], marking: MarkingSummary | undefined): readonly Candidate[] {
  const known = new Set(people.map(({ id }) => id));
  return [...people, ...(marking?.markers ?? []).filter(({ id }) => !known.has(id))];
}
