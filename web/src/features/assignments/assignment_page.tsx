import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { failed, type Tagged } from "../../api/http";
import type { Assignment } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useEdit } from "../../api/use_edit";
import { useRequest } from "../../api/use_request";
import { formatDateTime } from "../../base/format";
import { say } from "../../base/words";
import { Badge, Card, ErrorNotice, Notice, PageTitle, Waits } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { Confirm } from "../../widgets/dialog";
import { EditNotices } from "../../widgets/edit_notices";
import { countingText, endedTerms, exerciseTitle, handsText, limitText, outlineText, phaseOf } from "./assignment_text";
import { MoveCard } from "./move_card";
import { PhaseBadge } from "./my_work_page";
import { fitting, type Terms, TermsFields } from "./terms_fields";

interface Props {
  readonly client: Client;
  readonly id: string;
  readonly onGone: () => void;
  readonly insight: (assignment: Assignment) => ComponentChildren; // how the class did
  readonly marking: (assignment: Assignment) => ComponentChildren; // its blind markings
}

export function AssignmentPage({ client, id, onGone, insight, marking }: Props) {
  const { loaded, reload } = useRequest(id, (signal) => client.tagged("GET", "/assignments/{id}", { id, signal }));
  const [newer, setNewer] = useState<Tagged<Assignment>>();
  if (loaded.state !== "ready")
    return (
      <Waits loaded={loaded} reload={reload} what={say("loading.assignment")} failed={say("assignments.failed")}>
        <PageTitle document={say("assignments.one")}>{say("assignments.one")}</PageTitle>
      </Waits>
    );
  const { value: assignment, tag } = newer ?? loaded.value;
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href="/assignments">{say("nav.assignments")}</a>
      </nav>
      <div class="title-row">
        <PageTitle document={exerciseTitle(assignment)}>{exerciseTitle(assignment)}</PageTitle>
        {assignment.exam && <Badge tone="warning">{say("attempt_flag.exam")}</Badge>}
        <PhaseBadge assignment={assignment} now={Date.now()} />
      </div>
      <p class="byline">
        {assignment.cohort === null ? (
          say("common.everybody")
        ) : (
          <a href={`/cohorts/${assignment.cohort.id}`}>{assignment.cohort.name}</a>
        )}
        {" · "}
        {assignment.exercise.id !== null && (
          <>
            <a href={`/exercises/${assignment.exercise.id}`}>
              {say("assignments.version", { version: String(assignment.exercise.version) })}
            </a>
            {" · "}
          </>
        )}
        <a href={`/attempts?assignment=${assignment.id}`}>{say("assignments.attempts_under")}</a>
        {" · "}
        <a href={`/grading?assignment=${assignment.id}`}>{say("assignments.grade_them")}</a>
      </p>
      {insight(assignment)}
      <div class="columns">
        <Card title={say("assignments.terms")}>
          <EditTerms key={loaded.value.tag} client={client} read={loaded.value} onRead={setNewer} />
        </Card>
        <EndCard
          client={client}
          assignment={assignment}
          tag={tag}
          onChanged={() => {
            setNewer(undefined);
            reload();
          }}
        />
        <MoveCard
          client={client}
          assignment={assignment}
          tag={tag}
          onMoved={() => {
            setNewer(undefined);
            reload();
          }}
        />
        <Card title={say("assignments.scores")}>
          <Scores client={client} assignment={assignment} tag={tag} onGone={onGone} />
        </Card>
        {marking(assignment)}
      </div>
    </>
  );
}

// Ends it at once, and takes that back.
function EndCard({
  client,
  assignment,
  tag,
  onChanged,
}: {
  readonly client: Client;
  readonly assignment: Assignment;
  readonly tag: string;
  readonly onChanged: () => void;
}) {
  const [before, setBefore] = useState<Terms>();
  const change = useChange();
  const phase = phaseOf(assignment, Date.now());
  if (before === undefined && phase !== "open" && phase !== "late") return null;
  const save = async (terms: Terms, undo: Terms | undefined) => {
    const result = await change.run(() =>
      client.tagged("PUT", "/assignments/{id}", { id: assignment.id, body: sentTerms(assignment, terms), tag }),
    );
    if (result === undefined) return;
    if (result.ok) setBefore(undo);
    onChanged(); // also where somebody else was faster
  };
  const terms = termsOf(assignment);
  return (
    <Card title={say("assignments.end")}>
      <div aria-live="polite">
        {before !== undefined && (
          <Notice tone="good" title={say("assignments.ended")}>
            <button
              type="button"
              class="button small"
              disabled={change.busy}
              onClick={() =>
                void save({ ...terms, due_ms: before.due_ms, late_allowed: before.late_allowed }, undefined)
              }
            >
              {say("edit.undo")}
            </button>
          </Notice>
        )}
        {change.error !== undefined && <ErrorNotice title={say("common.not_done")} message={change.error.message} />}
      </div>
      {before === undefined && (
        <div class="button-row">
          <button
            type="button"
            class="button"
            disabled={change.busy}
            onClick={() => void save(endedTerms(terms, Date.now()), terms)}
          >
            {say("assignments.end_now")}
          </button>
        </div>
      )}
      <p class="hint">{say("assignments.end_hint")}</p>
    </Card>
  );
}

function sentTerms({ exercise, cohort }: Assignment, terms: Terms) {
  return { exercise: exercise.name, cohort_id: cohort?.id ?? null, ...terms };
}

type Draft = Assignment;

const compared = () => [
  {
    title: say("assignments.opens"),
    text: (item: Draft) => (item.opens_ms === 0 ? say("assignments.at_once") : formatDateTime(item.opens_ms)),
  },
  {
    title: say("assignments.due"),
    text: (item: Draft) => (item.due_ms === 0 ? say("assignments.never") : formatDateTime(item.due_ms)),
  },
  {
    title: say("nav.attempts"),
    text: limitText,
  },
  {
    title: say("assignments.late_attempts"),
    text: (item: Draft) => (item.late_allowed ? say("assignments.accepted") : say("assignments.refused")),
  },
  {
    title: say("assignments.devices"),
    text: handsText,
  },
  {
    title: say("terms.outline"),
    text: outlineText,
  },
  {
    title: say("assignments.counts"),
    text: (item: Draft) => countingText(item.counting),
  },
  {
    title: say("attempt_flag.exam"),
    text: (item: Draft) => (item.exam ? say("common.yes") : say("common.no")),
  },
  {
    title: say("terms.sign_off"),
    text: (item: Draft) => (item.sign_off ? say("common.yes") : say("common.no")),
  },
  {
    title: say("nav.stations"),
    text: (item: Draft) => item.stations.map((station) => station.name).join(", "),
  },
];

function EditTerms({
  client,
  read,
  onRead,
}: {
  readonly client: Client;
  readonly read: Tagged<Assignment>;
  readonly onRead: (read: Tagged<Assignment>) => void;
}) {
  const stations = useRequest("stations", (signal) => client.all("/stations", { signal }));
  const known = stations.loaded.state === "ready" ? stations.loaded.value : [];
  const edit = useEdit(
    read,
    (draft, tag) =>
      client.tagged("PUT", "/assignments/{id}", { id: draft.id, body: sentTerms(draft, termsOf(draft)), tag }),
    onRead,
  );
  const submit = (event: Event) => {
    event.preventDefault();
    void edit.save();
  };
  const set = ({ station_ids: ids, ...part }: Partial<Terms>) =>
    edit.set(
      ids === undefined
        ? part
        : {
            ...part,
            stations: ids.map((id) => ({ id, name: known.find((station) => station.id === id)?.name ?? id })),
          },
    );
  return (
    <form class="form" onSubmit={submit}>
      <TermsFields
        terms={termsOf(edit.draft)}
        onTerms={set}
        problemOf={edit.problemOf}
        stations={known.filter(
          (station) => !station.revoked || edit.draft.stations.some((item) => item.id === station.id),
        )}
      />
      <EditNotices edit={edit} compared={compared()} fields={["opens_ms", "due_ms", "attempt_limit"]} />
      <div class="button-row">
        <Button busy={edit.busy} blocked={edit.changed ? undefined : say("rubric.nothing_changed")}>
          {say("common.save")}
        </Button>
      </div>
    </form>
  );
}

function termsOf({
  opens_ms,
  due_ms,
  attempt_limit,
  exam,
  late_allowed,
  sign_off,
  hands,
  outline,
  counting,
  stations,
}: Assignment): Terms {
  return fitting({
    opens_ms,
    due_ms,
    attempt_limit,
    exam,
    late_allowed,
    sign_off,
    hands,
    outline,
    counting,
    station_ids: stations.map((station) => station.id),
  });
}

function Scores({
  client,
  assignment,
  tag,
  onGone,
}: {
  readonly client: Client;
  readonly assignment: Assignment;
  readonly tag: string;
  readonly onGone: () => void;
}) {
  const [open, setOpen] = useState<"release" | "delete">();
  const [released, setReleased] = useState<number>();
  const close = () => setOpen(undefined);
  return (
    <>
      <div class="button-row">
        <button type="button" class="button primary" onClick={() => setOpen("release")}>
          {say("assignments.release_ask")}
        </button>
        <button type="button" class="button" onClick={() => setOpen("delete")}>
          {say("assignments.delete_ask")}
        </button>
      </div>
      <div aria-live="polite">
        {released !== undefined && (
          <Notice tone="good">
            <p>{released === 0 ? say("assignments.nothing_to_release") : say("bulk.released", { count: released })}</p>
          </Notice>
        )}
      </div>
      <p class="hint">{say("assignments.release_hint")}</p>
      {open === "release" && (
        <Confirm
          title={say("assignments.release_title")}
          action={say("assignments.release_all")}
          tone="neutral"
          onClose={close}
          onConfirm={() =>
            failed(client.post("/assignments/{id}/release", { id: assignment.id }), (done) =>
              setReleased(done.released),
            )
          }
        >
          <p>{say("assignments.release_text")}</p>
        </Confirm>
      )}
      {open === "delete" && (
        <Confirm
          title={say("assignments.delete_title")}
          action={say("common.delete")}
          onClose={close}
          onConfirm={() => failed(client.delete("/assignments/{id}", { id: assignment.id, tag }), onGone)}
        >
          <p>{say("assignments.delete_text")}</p>
        </Confirm>
      )}
    </>
  );
}
