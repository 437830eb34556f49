import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Tagged } from "../../api/http";
import type { Exercise, RubricVersion, ScoringMetric } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useCheck } from "../../api/use_check";
import { useRequest } from "../../api/use_request";
import type { Json } from "../../base/document";
import { formatDateTime } from "../../base/format";
import { ok } from "../../base/result";
import { Card, ErrorNotice, Loading, PageTitle } from "../../widgets/basics";
import { DocumentChanges } from "../../widgets/document_changes";
import { EditBar } from "../../widgets/edit_bar";
import { LongTextField, SelectField } from "../../widgets/form";
import { useDocument } from "../../widgets/use_document";
import { placeTitle } from "./editor_text";
import { Problem, stateText } from "./exercise_editor";
import { versionText } from "./exercise_text";
import { RubricFields } from "./rubric_fields";
import { RubricPreviewCard } from "./rubric_preview";

interface Props {
  readonly client: Client;
  readonly id: string;
  readonly onOpen: (path: string) => void;
}

interface Read {
  readonly exercise: Exercise;
  readonly rubrics: Tagged<readonly RubricVersion[]>;  // newest first
  readonly metrics: readonly ScoringMetric[];
}

// The rubric of a published exercise, corrected: the exercise stays, scores change when they are made again.
export function RubricEditorPage({ client, id, onOpen }: Props) {
  const { loaded, reload } = useRequest(`rubric ${id}`, async (signal) => {
    const [exercise, rubrics, metrics] = await Promise.all([client.teaching.exercise(id, signal), client.teaching.rubrics(id, signal), client.teaching.metrics(signal)]);
    if (!exercise.ok) return exercise;
    if (!rubrics.ok) return rubrics;
    return metrics.ok ? ok<Read>({ exercise: exercise.value.value, rubrics: rubrics.value, metrics: metrics.value }) : metrics;
  });
  if (loaded.state === "loading") return <Loading what="the rubric" />;
  if (loaded.state === "failed") return <><PageTitle document="Rubric">Correct a rubric</PageTitle><ErrorNotice title="The rubric could not be loaded" message={loaded.error.message} onRetry={reload} /></>;
  return <Editor key={loaded.value.rubrics.tag} client={client} read={loaded.value} onOpen={onOpen} onNewer={reload} />;
}

function Editor({ client, read: { exercise, rubrics, metrics }, onOpen, onNewer }: { readonly client: Client; readonly read: Read; readonly onOpen: (path: string) => void; readonly onNewer: () => void }) {
  const [counting] = rubrics.value;
  const document = counting?.document as unknown as Json ?? null;
  const edit = useDocument(`rubric ${exercise.id}`, document);
  const check = useCheck(JSON.stringify(edit.now), (text, signal) => client.teaching.checkRubric(exercise.id, text, signal));
  const [reason, setReason] = useState("");
  const [against, setAgainst] = useState(String(counting?.version ?? 1));
  const change = useChange();
  const publish = async () => {
    const result = await change.run(() => client.teaching.publishRubric(exercise.id, edit.now, reason.trim(), rubrics.tag));
    if (result?.ok !== true) return;
    edit.forget();
    onOpen(`/exercises/${exercise.id}`);
  };
  const compared = rubrics.value.find((rubric) => String(rubric.version) === against);
  const may = exercise.may.includes("change");
  return (
    <>
      <nav class="trail" aria-label="Where you are"><a href={`/exercises/${exercise.id}`}>{exercise.title}</a></nav>
      <PageTitle document={`Rubric of ${exercise.title}`}>{`The rubric of ${exercise.title}, ${versionText(exercise)}`}</PageTitle>
      <EditBar edit={edit} state={stateText(check, edit.dirty)}>
        <button type="button" class="button primary" disabled={!may || change.busy || check.busy || check.error !== undefined || !edit.dirty || reason.trim() === ""} onClick={() => void publish()}>Publish the correction</button>
      </EditBar>
      <Problem check={check} />
      {change.error !== undefined && (change.error.status === 412
        ? <ErrorNotice title="Somebody corrected the rubric meanwhile" message="What you have typed stays here. Load the newer rubric, compare, and publish again." onRetry={onNewer} />
        : <ErrorNotice title="Not published" message={change.error.message} />)}
      <div class="editor">
        <div class="stack">
          <Card title="How it is scored"><RubricFields form={{ edit, wrong: check.error }} path={[]} metrics={metrics} /></Card>
        </div>
        <div class="stack editor-side">
          <Card title="The correction">
            <LongTextField label="Reason" hint="For colleagues and the audit trail. Scores that are there stay until they are made again." value={reason} onValue={setReason} maxLength={1000} rows={2} />
          </Card>
          <Card title="Versions">
            <SelectField label="Compare with" value={against} onValue={setAgainst} options={rubrics.value.map((rubric, i) => ({
              value: String(rubric.version), title: `Version ${rubric.version}, ${formatDateTime(rubric.published_ms)}${i === 0 ? ", counts" : ""}${rubric.reason === "" ? "" : `: ${rubric.reason}`}` }))} />
            {compared !== undefined && <DocumentChanges label="Changes against the chosen version" before={withoutVersion(compared.document as unknown as Json)} after={withoutVersion(edit.now)} beforeTitle={`Version ${compared.version}`} afterTitle="Here" titleOf={(item) => placeTitle(item, edit.now)} />}
          </Card>
          <RubricPreviewCard client={client} exercise={exercise.id} rubric={edit.now} />
        </div>
      </div>
    </>
  );
}

// The server numbers them.
function withoutVersion(document: Json): Json {
  const { version: _version, ...rest } = document as { readonly [name: string]: Json };
  return rest;
}
