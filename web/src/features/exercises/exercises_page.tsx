import { useState } from "preact/hooks";
import { exerciseTitle, wordedText } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { ExerciseState, ExerciseSummary } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime } from "../../base/format";
import { say } from "../../base/words";
import { Badge, Card, Empty, Folded, PageTitle, Segmented, Waits } from "../../widgets/basics";
import { Dialog } from "../../widgets/dialog";
import { part } from "../../widgets/part";
import { DataTable } from "../../widgets/table";
import { Copying } from "./copying";
import { DocumentForm, putDraft } from "./document_form";

// Most people never add one.
const ToothImport = part("tooth_import", () => import("./tooth_import"));
import { burText, ownerText, timeLimitText, versionText } from "./exercise_text";

export function ExercisesPage({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("exercises", (signal) => client.all("/exercises", { signal }));
  return (
    <>
      <PageTitle document={say("nav.exercises")}>{say("nav.exercises")}</PageTitle>
      <Waits loaded={loaded} reload={reload} what={say("loading.exercises")} failed={say("exercise_list.failed")} />
      {loaded.state === "ready" && loaded.value.length === 0 && <Empty>{say("exercise_list.none_mine")}</Empty>}
      {loaded.state === "ready" && (
        <ul class="card-list">
          {loaded.value.map((exercise) => (
            <li key={exercise.id}>
              <ExerciseCard exercise={exercise} />
            </li>
          ))}
        </ul>
      )}
    </>
  );
}

function ExerciseCard({ exercise }: { readonly exercise: ExerciseSummary }) {
  return (
    <article class="card exercise">
      <div class="card-head">
        <h2>
          <a href={`/exercises/${exercise.id}`}>{exerciseTitle(exercise)}</a>
        </h2>
        <Badge tone="neutral">{exercise.graded ? say("exercise_page.graded") : say("exercise_list.practice")}</Badge>
      </div>
      <p class="instructions">{wordedText(exercise.instructions)}</p>
      <dl class="facts">
        <div>
          <dt>{say("exercise_page.bur")}</dt>
          <dd>{burText(exercise.burs)}</dd>
        </div>
        <div>
          <dt>{say("nav.my_attempts")}</dt>
          <dd>{exercise.my_attempts}</dd>
        </div>
        <div>
          <dt>{say("attempt_flag.reference")}</dt>
          <dd>{exercise.has_reference ? say("exercise_list.available") : say("exercise_list.none_yet")}</dd>
        </div>
        {exercise.time_limit_s > 0 && (
          <div>
            <dt>{say("exercise_page.time_limit")}</dt>
            <dd>{timeLimitText(exercise.time_limit_s)}</dd>
          </div>
        )}
      </dl>
    </article>
  );
}

const empty = (): Readonly<Record<ExerciseState, string>> => ({
  draft: say("exercise_list.no_draft"),
  published: say("exercise_list.none_published"),
  retired: say("exercise_list.none_retired"),
});

interface StaffProps {
  readonly client: Client;
  readonly admin: boolean;
  readonly mayImport: boolean; // teeth
  readonly query: URLSearchParams;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
  readonly onOpen: (path: string) => void;
}

// For instructors: drafts, published and retired exercises.
export function StaffExercisesPage({ client, admin, mayImport, query, onQuery, onOpen }: StaffProps) {
  const asked = query.get("state");
  const state: ExerciseState = asked === "draft" || asked === "retired" ? asked : "published";
  const { loaded, reload } = useRequest(state, (signal) => client.all("/exercises", { state, signal }));
  const [adding, setAdding] = useState(false);
  const importing = mayImport && query.get("import") === "tooth";
  const closeImport = () => onQuery({ import: "" });
  return (
    <>
      <div class="toolbar">
        <PageTitle document={say("nav.exercises")}>{say("nav.exercises")}</PageTitle>
        <div class="button-row">
          {mayImport && (
            <button type="button" class="button" onClick={() => onQuery({ import: "tooth" })}>
              {say("tooth_import.ask")}
            </button>
          )}
          <button type="button" class="button primary" onClick={() => setAdding(true)}>
            {say("exercise_list.add_ask")}
          </button>
        </div>
      </div>
      <Segmented
        legend={say("exercise_list.show")}
        name="state"
        value={state}
        onChange={(value) => onQuery({ state: value })}
        choices={[
          { value: "published", title: say("exercise_state.published") },
          { value: "draft", title: say("exercise_list.drafts") },
          { value: "retired", title: say("exercise_state.retired") },
        ]}
      />
      <Waits loaded={loaded} reload={reload} what={say("loading.exercises")} failed={say("exercise_list.failed")} />
      {loaded.state === "ready" &&
        (loaded.value.length === 0 ? (
          <Empty>{empty()[state]}</Empty>
        ) : (
          <Card className="flush">
            <DataTable
              label={say("nav.exercises")}
              items={loaded.value}
              rowKey={(exercise) => exercise.id}
              columns={[
                {
                  title: say("common.exercise"),
                  cell: (exercise) => <a href={`/exercises/${exercise.id}`}>{exerciseTitle(exercise)}</a>,
                },
                {
                  title: say("account.name"),
                  cell: (exercise) => (
                    <span>
                      <code>{exercise.name}</code>, {versionText(exercise)}
                    </span>
                  ),
                },
                { title: say("exercise_list.owner"), cell: ownerText },
                {
                  title: say("insight.kind"),
                  cell: (exercise) => (exercise.graded ? say("exercise_page.graded") : say("exercise_list.practice")),
                },
                { title: say("exercise_page.bur"), cell: (exercise) => burText(exercise.burs) },
                { title: say("exercise_page.time_limit"), cell: (exercise) => timeLimitText(exercise.time_limit_s) },
                {
                  title: say("attempt_flag.reference"),
                  cell: (exercise) =>
                    exercise.has_reference ? (
                      <Badge tone="good">{say("exercise_list.available")}</Badge>
                    ) : (
                      <Badge tone="warning">{say("exercise_list.none_yet")}</Badge>
                    ),
                },
                { title: say("listed.since"), cell: (exercise) => formatDateTime(exercise.published_ms) },
              ]}
            />
          </Card>
        ))}
      {importing && (
        <Dialog wide title={say("tooth_import.title")} onClose={closeImport}>
          <ToothImport
            show={({ AddTooth }) => <AddTooth client={client} admin={admin} onDone={reload} onClose={closeImport} />}
          />
        </Dialog>
      )}
      {adding && (
        <Dialog title={say("exercise_list.add")} onClose={() => setAdding(false)}>
          <Copying
            show={({ CopyForm }) => (
              <CopyForm
                client={client}
                onCancel={() => setAdding(false)}
                onDone={(exercise) => onOpen(`/editor?exercise=${exercise.id}`)}
              />
            )}
          />
          <Folded
            title={say("copy_exercise.from_file")}
            content={() => (
              <DocumentForm
                action={say("common.add")}
                onCancel={() => setAdding(false)}
                send={(text) => putDraft(client, text)}
                onDone={(exercise) => onOpen(`/exercises/${exercise.id}`)}
              />
            )}
          />
        </Dialog>
      )}
    </>
  );
}
