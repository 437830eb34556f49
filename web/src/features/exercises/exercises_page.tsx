import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ExerciseState, ExerciseSummary } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime } from "../../base/format";
import { Badge, Card, Empty, ErrorNotice, Loading, PageTitle, Segmented } from "../../widgets/basics";
import { Dialog } from "../../widgets/dialog";
import { DataTable } from "../../widgets/table";
import { DocumentForm } from "./document_form";
import { burText, ownerText, timeLimitText, versionText } from "./exercise_text";

export function ExercisesPage({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("exercises", (signal) => client.teaching.exercises(undefined, signal));
  return (
    <>
      <PageTitle document="Exercises">Exercises</PageTitle>
      {loaded.state === "loading" && <Loading what="exercises" />}
      {loaded.state === "failed" && <ErrorNotice title="The exercises could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && loaded.value.length === 0 &&
        <Empty>No exercise is assigned to you yet. Your instructor adds them to your cohort.</Empty>}
      {loaded.state === "ready" && (
        <ul class="card-list">
          {loaded.value.map((exercise) => <li key={exercise.id}><ExerciseCard exercise={exercise} /></li>)}
        </ul>
      )}
    </>
  );
}

function ExerciseCard({ exercise }: { readonly exercise: ExerciseSummary }) {
  return (
    <article class="card exercise">
      <div class="card-head">
        <h2><a href={`/exercises/${exercise.id}`}>{exercise.title}</a></h2>
        <Badge tone="neutral">{exercise.graded ? "Graded" : "Practice"}</Badge>
      </div>
      <p class="instructions">{exercise.instructions}</p>
      <dl class="facts">
        <div><dt>Bur</dt><dd>{burText(exercise.bur)}</dd></div>
        <div><dt>My attempts</dt><dd>{exercise.my_attempts}</dd></div>
        <div><dt>Reference</dt><dd>{exercise.has_reference ? "Available" : "None yet"}</dd></div>
        {exercise.time_limit_s > 0 && <div><dt>Time limit</dt><dd>{timeLimitText(exercise.time_limit_s)}</dd></div>}
      </dl>
    </article>
  );
}

const kEmpty: Readonly<Record<ExerciseState, string>> = {
  draft: "There is no draft. Add one from a document.", published: "Nothing is published yet.", retired: "Nothing is retired.",
};

interface StaffProps {
  readonly client: Client;
  readonly query: URLSearchParams;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
  readonly onOpen: (path: string) => void;
}

// For who teaches: drafts, published and retired exercises.
export function StaffExercisesPage({ client, query, onQuery, onOpen }: StaffProps) {
  const asked = query.get("state");
  const state: ExerciseState = asked === "draft" || asked === "retired" ? asked : "published";
  const { loaded, reload } = useRequest(state, (signal) => client.teaching.exercises(state, signal));
  const [adding, setAdding] = useState(false);
  return (
    <>
      <div class="toolbar">
        <PageTitle document="Exercises">Exercises</PageTitle>
        <button type="button" class="button primary" onClick={() => setAdding(true)}>Add a draft…</button>
      </div>
      <Segmented legend="Show" name="state" value={state} onChange={(value) => onQuery({ state: value })}
                 choices={[{ value: "published", title: "Published" }, { value: "draft", title: "Drafts" }, { value: "retired", title: "Retired" }]} />
      {loaded.state === "loading" && <Loading what="exercises" />}
      {loaded.state === "failed" && <ErrorNotice title="The exercises could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (loaded.value.length === 0 ? <Empty>{kEmpty[state]}</Empty> : (
        <Card className="flush">
          <DataTable label="Exercises" items={loaded.value} rowKey={(exercise) => exercise.id} columns={[
            { title: "Exercise", cell: (exercise) => <a href={`/exercises/${exercise.id}`}>{exercise.title}</a> },
            { title: "Name", cell: (exercise) => <><code>{exercise.name}</code>, {versionText(exercise)}</> },
            { title: "Owner", cell: ownerText },
            { title: "Kind", cell: (exercise) => exercise.graded ? "Graded" : "Practice" },
            { title: "Bur", cell: (exercise) => burText(exercise.bur) },
            { title: "Time limit", cell: (exercise) => timeLimitText(exercise.time_limit_s) },
            { title: "Reference", cell: (exercise) => exercise.has_reference ? <Badge tone="good">Available</Badge> : <Badge tone="warning">None yet</Badge> },
            { title: "Since", cell: (exercise) => formatDateTime(exercise.published_ms) },
          ]} />
        </Card>
      ))}
      {adding && (
        <Dialog title="Add a draft" onClose={() => setAdding(false)}>
          <DocumentForm action="Add" onCancel={() => setAdding(false)} send={(text) => client.teaching.putDraft(text)}
                        onDone={(exercise) => onOpen(`/exercises/${exercise.id}`)} />
        </Dialog>
      )}
    </>
  );
}
