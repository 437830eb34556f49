import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Tagged } from "../../api/http";
import type { Exercise, ScoringMetric } from "../../api/types";
import { useChange } from "../../api/use_change";
import { type Checked, useCheck } from "../../api/use_check";
import { useRequest } from "../../api/use_request";
import { type Json, valueAt } from "../../base/document";
import { ok } from "../../base/result";
import { Card, ErrorNotice, Loading, Notice, PageTitle } from "../../widgets/basics";
import { type DocumentForm, DocumentChoice, DocumentFlag, DocumentNumber, DocumentText } from "../../widgets/document_fields";
import { DocumentChanges } from "../../widgets/document_changes";
import { EditBar } from "../../widgets/edit_bar";
import { useDocument } from "../../widgets/use_document";
import { kShapes, placeTitle } from "./editor_text";
import { versionText } from "./exercise_text";
import { RubricFields } from "./rubric_fields";
import { RubricPreviewCard } from "./rubric_preview";

const kMm = 1000;

interface Props {
  readonly client: Client;
  readonly id: string;
  readonly onOpen: (path: string) => void;
}

interface Read {
  readonly exercise: Tagged<Exercise>;
  readonly document: Json;
  readonly metrics: readonly ScoringMetric[];
  readonly published: { readonly id: string; readonly title: string; readonly document: Json } | undefined;  // the newest version
  readonly draft: string | undefined;           // another one of that name
}

// An exercise in a form: a draft is changed, a published version gives a new draft.
export function ExerciseEditorPage({ client, id, onOpen }: Props) {
  const { loaded, reload } = useRequest(`editor ${id}`, async (signal) => {
    const [exercise, document, metrics, versions] = await Promise.all([client.teaching.exercise(id, signal), client.teaching.document(id, signal), client.teaching.metrics(signal), client.teaching.versions(id, signal)]);
    if (!exercise.ok) return exercise;
    if (!document.ok) return document;
    if (!metrics.ok) return metrics;
    if (!versions.ok) return versions;
    const newest = versions.value.find((version) => version.state !== "draft");
    const before = newest === undefined ? undefined : await client.teaching.document(newest.id, signal);
    if (before !== undefined && !before.ok) return before;
    const published = newest === undefined || before === undefined ? undefined : { id: newest.id, title: versionText(newest), document: before.value };
    return ok<Read>({ exercise: exercise.value, document: document.value, metrics: metrics.value, published, draft: versions.value.find((version) => version.state === "draft" && version.id !== id)?.id });
  });
  if (loaded.state === "loading") return <Loading what="the exercise" />;
  if (loaded.state === "failed") return <><PageTitle document="Edit">Edit an exercise</PageTitle><ErrorNotice title="The exercise could not be loaded" message={loaded.error.message} onRetry={reload} /></>;
  return <Editor key={loaded.value.exercise.tag} client={client} read={loaded.value} onOpen={onOpen} onNewer={reload} />;
}

function Editor({ client, read, onOpen, onNewer }: { readonly client: Client; readonly read: Read; readonly onOpen: (path: string) => void; readonly onNewer: () => void }) {
  const { value: exercise, tag } = read.exercise;
  const isDraft = exercise.state === "draft";
  const edit = useDocument(`exercise ${exercise.id}`, read.document);
  const text = JSON.stringify(edit.now);
  const check = useCheck(text, (asked, signal) => client.teaching.checkExercise(asked, signal));
  const change = useChange();
  const form: DocumentForm = { edit, wrong: check.error };
  const save = async () => {
    const result = await change.run(() => isDraft ? client.teaching.replaceDraft(exercise.id, text, tag) : client.teaching.putDraft(text));
    if (result?.ok !== true) return;
    edit.forget();
    onOpen(`/exercises/${result.value.id}`);
  };
  const rubric = valueAt(edit.now, ["rubric"]) as { readonly [name: string]: Json } | undefined;
  return (
    <>
      <nav class="trail" aria-label="Where you are"><a href={`/exercises/${exercise.id}`}>{exercise.title}</a></nav>
      <PageTitle document={`Edit ${exercise.title}`}>{isDraft ? `Edit the draft of ${exercise.title}` : `A new draft from ${exercise.title}, ${versionText(exercise)}`}</PageTitle>
      {!isDraft && read.draft !== undefined && <Notice tone="warning"><p>There is a draft of this exercise already. <a href={`/editor?exercise=${read.draft}`}>Edit that one</a></p></Notice>}
      <EditBar edit={edit} state={stateText(check, edit.dirty)}>
        <button type="button" class="button primary" disabled={change.busy || check.busy || check.error !== undefined || (isDraft && !edit.dirty)} onClick={() => void save()}>{isDraft ? "Save the draft" : "Make the draft"}</button>
      </EditBar>
      <Problem check={check} />
      {change.error !== undefined && (change.error.status === 412
        ? <ErrorNotice title="Somebody changed the draft meanwhile" message="What you have typed stays here. Load the newer draft, compare below, and save again." onRetry={onNewer} />
        : <ErrorNotice title="Not saved" message={change.error.message} />)}
      <div class="editor">
        <div class="stack">
          <General form={form} />
          <Tool form={form} />
          <Target form={form} />
          <Card title="How it is scored"><RubricFields form={form} path={["rubric"]} metrics={read.metrics} /></Card>
        </div>
        <div class="stack editor-side">
          <Card title={read.published === undefined ? "Changes" : `Changes against ${read.published.title}`}>
            {read.published === undefined ? <p class="hint">No version is published yet: there is nothing to compare with.</p>
              : <DocumentChanges label="Changes against the published version" before={read.published.document} after={edit.now} beforeTitle="Published" afterTitle="Here" titleOf={(item) => placeTitle(item, edit.now)} />}
          </Card>
          {read.published !== undefined && rubric !== undefined && <RubricPreviewCard client={client} exercise={read.published.id} rubric={rubricDocument(rubric)} />}
        </div>
      </div>
    </>
  );
}

const kRubricFormat = 1;
const kDocuments = new WeakMap<object, Json>();

// A rubric by itself says its own format (schemas/rubric.schema.json). The same one for the same rubric, so that it can be told apart.
function rubricDocument(rubric: { readonly [name: string]: Json }): Json {
  const known = kDocuments.get(rubric);
  if (known !== undefined) return known;
  const document = { format: kRubricFormat, ...rubric };
  kDocuments.set(rubric, document);
  return document;
}

export function stateText({ busy, error }: Checked<unknown>, dirty: boolean): string {
  if (busy) return "Checking…";
  if (error !== undefined) return "Not right yet";
  return dirty ? "Right, not saved" : "As saved";
}

// What the server found wrong, and where: beside the field too, where it has one.
export function Problem({ check }: { readonly check: Checked<{ readonly warnings: readonly string[] }> }) {
  return (
    <div aria-live="polite" class="edit-notices">
      {check.error !== undefined && <Notice tone="bad" title="Not right yet"><p>{check.error.field === "" ? "" : `${check.error.field}: `}{check.error.message}</p></Notice>}
      {check.error === undefined && check.value?.warnings.map((warning) => <Notice key={warning} tone="warning"><p>{warning}</p></Notice>)}
    </div>
  );
}

function General({ form }: { readonly form: DocumentForm }) {
  return (
    <Card title="What it is">
      <div class="form">
        <DocumentText form={form} path={["title"]} label="Title" maxLength={200} />
        <DocumentText form={form} path={["instructions"]} label="What students read" maxLength={4000} long />
        <div class="form-grid">
          <DocumentNumber form={form} path={["time_limit_s"]} label="Time limit (min)" hint="0: none" scale={60} min={0} />
          <DocumentFlag form={form} path={["graded"]} label="Graded" hint="The score shows after release; else at once." />
        </div>
      </div>
    </Card>
  );
}

function Tool({ form }: { readonly form: DocumentForm }) {
  const { edit } = form;
  const ball = edit.at(["bur", "shape"]) === "sphere";
  const handpiece = edit.at(["handpiece"]) !== undefined;
  const cues = edit.at(["touch_cues"]) !== undefined;
  return (
    <Card title="Bur and handpiece">
      <div class="form">
        <div class="form-grid">
          <DocumentChoice form={form} path={["bur", "shape"]} label="Shape" options={kShapes} />
          <DocumentNumber form={form} path={["bur", "radius_um"]} label="Radius (mm)" scale={kMm} />
          <DocumentNumber form={form} path={["bur", "length_um"]} label="Cutting length (mm)" hint={ball ? "0 for a ball" : "At least 0.1"} scale={kMm} />
          <DocumentNumber form={form} path={["bur", "narrow_radius_um"]} label="Narrow radius (mm)" hint="Of cones, pears and flames" scale={kMm} optional />
          <DocumentNumber form={form} path={["bur", "shank_radius_um"]} label="Shank radius (mm)" hint="Empty: no shank" scale={kMm} optional />
          <DocumentNumber form={form} path={["bur", "neck_um"]} label="Neck (mm)" scale={kMm} optional />
        </div>
        <Part form={form} on={handpiece} member="handpiece" label="The handpiece slows down under load" fresh={{ stall_un_m: 3000, tangential_permille: 300, lag_us: 50_000 }}>
          <DocumentNumber form={form} path={["handpiece", "stall_un_m"]} label="Stands still at (mN m)" scale={1000} />
          <DocumentNumber form={form} path={["handpiece", "tangential_permille"]} label="Tangential force (% of the resisting)" scale={10} />
          <DocumentNumber form={form} path={["handpiece", "lag_us"]} label="Follows within (ms)" scale={1000} />
        </Part>
        <Part form={form} on={cues} member="touch_cues" label="Knock and chatter can be felt" fresh={{ contact_mn: 300, chatter_mn: 120, energy_uj: 250, power_uw: 800 }}>
          <DocumentNumber form={form} path={["touch_cues", "contact_mn"]} label="Knock (N)" scale={1000} min={0} />
          <DocumentNumber form={form} path={["touch_cues", "chatter_mn"]} label="Chatter (N)" scale={1000} min={0} />
          <DocumentNumber form={form} path={["touch_cues", "energy_uj"]} label="Energy at once (µJ)" whole />
          <DocumentNumber form={form} path={["touch_cues", "power_uw"]} label="Energy over time (µW)" whole min={0} />
        </Part>
      </div>
    </Card>
  );
}

// A part of the document that may be left out.
function Part({ form, on, member, label, fresh, children }: { readonly form: DocumentForm; readonly on: boolean; readonly member: string; readonly label: string; readonly fresh: Json; readonly children: ComponentChildren }) {
  const [id] = useState(() => `part_${member}`);
  return (
    <fieldset class="group">
      <legend>{label}</legend>
      <div class="field check">
        <input type="checkbox" id={id} checked={on} onChange={(event) => form.edit.set([member], event.currentTarget.checked ? fresh : undefined)} />
        <label for={id}>Yes</label>
      </div>
      {on && <div class="form-grid">{children}</div>}
    </fieldset>
  );
}

function Target({ form }: { readonly form: DocumentForm }) {
  const parts = form.edit.at(["target", "parts"]);
  return (
    <Card title="What is to be cut">
      <div class="form">
        {Array.isArray(parts) && <Notice tone="neutral"><p>The target is made of {parts.length} parts, whose shapes a form does not show. Size and depth below are the box that holds them.</p></Notice>}
        <div class="form-grid">
          <DocumentNumber form={form} path={["target", "half_size_um", 0]} label="Length, mesial to distal (mm)" scale={kMm / 2} />
          <DocumentNumber form={form} path={["target", "half_size_um", 1]} label="Width, buccal to lingual (mm)" scale={kMm / 2} />
          <DocumentNumber form={form} path={["target", "depth_um"]} label="Depth (mm)" scale={kMm} />
          <DocumentNumber form={form} path={["target", "leeway_side_um"]} label="May go beyond the walls (mm)" scale={kMm} min={0} />
          <DocumentNumber form={form} path={["target", "leeway_bottom_um"]} label="May go below the floor (mm)" scale={kMm} min={0} />
          <DocumentNumber form={form} path={["target", "container_um"]} label="Must stay around that (mm)" scale={kMm} min={0} />
        </div>
      </div>
    </Card>
  );
}
