import type { ComponentChildren } from "preact";
import { useMemo, useState } from "preact/hooks";
import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { ApiResult, Tagged } from "../../api/http";
import type { Exercise, ScoringMetric } from "../../api/types";
import { useChange } from "../../api/use_change";
import { type Checked, useCheck } from "../../api/use_check";
import { useRequest } from "../../api/use_request";
import { placedMessage } from "../../api/placed";
import { type Json, pathOf, valueAt } from "../../base/document";
import { ok } from "../../base/result";
import { say, sayWith } from "../../base/words";
import { Card, ErrorNotice, Notice, PageTitle, Waits } from "../../widgets/basics";
import {
  type DocumentForm,
  DocumentFlag,
  DocumentNumber,
  DocumentText,
  stillWrong,
} from "../../widgets/document_fields";
import { Button } from "../../widgets/button";
import { DocumentChanges } from "../../widgets/document_changes";
import { EditBar } from "../../widgets/edit_bar";
import { useDocument } from "../../widgets/use_document";
import { BurFields, OtherBurs } from "./bur_fields";
import { putDraft } from "./document_form";
import { placeTitle, placeWords, rubricProblems } from "./editor_text";
import { versionText } from "./exercise_text";
import { RubricFields } from "./rubric_fields";
import { RubricPreviewCard } from "./rubric_preview";
import { mendedText, staleLengths } from "./stale_text";
import { TargetPreview } from "./target_preview";
import { TrialCard } from "./trial_card";

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
  readonly published: { readonly id: string; readonly title: string; readonly document: Json } | undefined; // the newest version
  readonly draft: string | undefined; // another one of that name
}

interface Warnings {
  readonly warnings: readonly string[];
}

// An exercise in a form: a draft is changed, a published version gives a new draft.
export function ExerciseEditorPage({ client, id, onOpen }: Props) {
  const { loaded, reload } = useRequest(`editor ${id}`, async (signal) => {
    const [exercise, document, metrics, versions] = await Promise.all([
      client.tagged("GET", "/exercises/{id}", { id, signal }),
      client.get("/exercises/{id}/document", { id, signal }),
      client.get("/scoring-metrics", { signal }),
      client.all("/exercises/{id}/versions", { id, signal }),
    ]);
    if (!exercise.ok) return exercise;
    if (!document.ok) return document;
    if (!metrics.ok) return metrics;
    if (!versions.ok) return versions;
    const newest = versions.value.find((version) => version.state !== "draft");
    const before =
      newest === undefined ? undefined : await client.get("/exercises/{id}/document", { id: newest.id, signal });
    if (before !== undefined && !before.ok) return before;
    const published =
      newest === undefined || before === undefined
        ? undefined
        : { id: newest.id, title: versionText(newest), document: before.value };
    return ok<Read>({
      exercise: exercise.value,
      document: document.value,
      metrics: metrics.value.metrics,
      published,
      draft: versions.value.find((version) => version.state === "draft" && version.id !== id)?.id,
    });
  });
  if (loaded.state !== "ready")
    return (
      <Waits loaded={loaded} reload={reload} what={say("loading.exercise")} failed={say("exercise_page.failed")}>
        <PageTitle document={say("editor.document")}>{say("editor.title")}</PageTitle>
      </Waits>
    );
  return (
    <Editor key={loaded.value.exercise.tag} client={client} read={loaded.value} onOpen={onOpen} onNewer={reload} />
  );
}

function Editor({
  client,
  read,
  onOpen,
  onNewer,
}: {
  readonly client: Client;
  readonly read: Read;
  readonly onOpen: (path: string) => void;
  readonly onNewer: () => void;
}) {
  const { value: exercise, tag } = read.exercise;
  const isDraft = exercise.state === "draft";
  const edit = useDocument(`exercise ${exercise.id}`, read.document);
  const text = JSON.stringify(edit.now);
  const check = useCheck(
    text,
    (body, signal) => client.post("/exercises", { dry_run: true, body, signal }) as Promise<ApiResult<Warnings>>,
  );
  const change = useChange();
  const own = useMemo(() => rubricProblems(edit.now, ["rubric"]), [edit.now]);
  const form: DocumentForm = { edit, wrong: stillWrong(check, edit.now), own };
  const wrong = check.error !== undefined || own.size > 0 ? say("rubric.mend_first") : undefined;
  const save = async () => {
    const result = await change.run(() =>
      isDraft ? client.put("/exercises/{id}", { id: exercise.id, body: text, tag }) : putDraft(client, text),
    );
    if (result?.ok !== true) return;
    edit.forget();
    onOpen(`/exercises/${result.value.id}`);
  };
  const rubric = valueAt(edit.now, ["rubric"]) as { readonly [name: string]: Json } | undefined;
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href={`/exercises/${exercise.id}`}>{wordedTitle(exercise.title)}</a>
      </nav>
      <PageTitle document={say("editor.edit", { title: wordedTitle(exercise.title) })}>
        {isDraft
          ? say("editor.edit_draft", { title: wordedTitle(exercise.title) })
          : say("editor.new_draft", { title: wordedTitle(exercise.title), version: versionText(exercise) })}
      </PageTitle>
      {!isDraft && read.draft !== undefined && (
        <Notice tone="warning">
          <p>
            {sayWith("editor.draft_there", {
              edit: <a href={`/editor?exercise=${read.draft}`}>{say("editor.edit_that")}</a>,
            })}
          </p>
        </Notice>
      )}
      <EditBar edit={edit} state={stateText(check, edit.dirty, own.size > 0)}>
        <Button
          busy={change.busy || check.busy}
          blocked={wrong ?? (isDraft && !edit.dirty ? say("rubric.nothing_changed") : undefined)}
          onClick={() => void save()}
        >
          {isDraft ? say("editor.save_draft") : say("editor.make_draft")}
        </Button>
      </EditBar>
      <Problem check={check} form={form} />
      {change.error !== undefined &&
        (change.error.status === 412 ? (
          <ErrorNotice
            title={say("editor.draft_changed")}
            message={say("editor.draft_changed_text")}
            onRetry={onNewer}
          />
        ) : (
          <ErrorNotice title={say("common.not_saved")} message={change.error.message} />
        ))}
      <div class="editor">
        <div class="stack">
          <General form={form} read={read.document} />
          <Tool form={form} />
          <Target form={form} />
          <Card title={say("exercise_page.scored")}>
            <RubricFields form={form} path={["rubric"]} metrics={read.metrics} />
          </Card>
        </div>
        <div class="stack editor-side">
          <TargetPreview client={client} exercise={exercise} target={valueAt(edit.now, ["target"])} />
          <TrialCard client={client} text={text} blocked={wrong} />
          <Card
            title={
              read.published === undefined
                ? say("editor.changes")
                : say("editor.changes_against", { title: read.published.title })
            }
          >
            {read.published === undefined ? (
              <p class="hint">{say("editor.none_published")}</p>
            ) : (
              <DocumentChanges
                label={say("editor.changes_published")}
                before={read.published.document}
                after={edit.now}
                beforeTitle={say("exercise_state.published")}
                afterTitle={say("editor.here")}
                titleOf={(item) => placeTitle(item, edit.now)}
              />
            )}
          </Card>
          {read.published !== undefined && rubric !== undefined && (
            <RubricPreviewCard client={client} exercise={read.published.id} rubric={rubricDocument(rubric)} />
          )}
        </div>
      </div>
    </>
  );
}

const kRubricFormat = 1;
const kDocuments = new WeakMap<object, Json>();

// A rubric by itself names its kind and format (schemas/rubric.schema.json). The same one for the same
// rubric, so that the two differ.
function rubricDocument(rubric: { readonly [name: string]: Json }): Json {
  const known = kDocuments.get(rubric);
  if (known !== undefined) return known;
  const document = { enamel_rubric: kRubricFormat, ...rubric };
  kDocuments.set(rubric, document);
  return document;
}

export function stateText({ busy, error }: Checked<unknown>, dirty: boolean, wrong: boolean): string {
  if (busy && !wrong) return say("editor.checking");
  if (wrong || error !== undefined) return say("editor.not_right");
  return dirty ? say("editor.right_not_saved") : say("editor.as_saved");
}

// What is wrong, and where: beside the field too, where it has one.
export function Problem({
  check,
  form: { edit, wrong, own },
}: {
  readonly check: Checked<Warnings>;
  readonly form: DocumentForm;
}) {
  const placed = (field: string) => placeWords(pathOf(field), edit.now);
  const [seen] = own ?? [];
  const said =
    seen !== undefined
      ? say("editor.placed", { place: placed(seen[0]), problem: seen[1] })
      : wrong === undefined
        ? undefined
        : placedMessage(wrong, placed(wrong.field));
  return (
    <div aria-live="polite" class="edit-notices">
      {said !== undefined && (
        <Notice tone="bad" title={say("editor.not_right")}>
          <p>{said}</p>
        </Notice>
      )}
      {said === undefined &&
        check.error === undefined &&
        check.value?.warnings.map((warning) => (
          <Notice key={warning} tone="warning">
            <p>{warning}</p>
          </Notice>
        ))}
    </div>
  );
}

function General({ form, read }: { readonly form: DocumentForm; readonly read: Json }) {
  const stale = staleLengths(read, form.edit.now);
  return (
    <Card title={say("editor.what")}>
      <div class="form">
        <DocumentText form={form} path={["title"]} label={say("editor.title_field")} maxLength={200} />
        <DocumentText form={form} path={["instructions"]} label={say("editor.instructions")} maxLength={4000} long />
        {stale.length > 0 && (
          <Notice tone="warning">
            {stale.map(({ said, now }) => (
              <p key={said}>{say("editor.stale_text", { said, now })}</p>
            ))}
            <button
              type="button"
              class="button small"
              onClick={() => form.edit.set(["instructions"], mendedText(String(form.edit.at(["instructions"])), stale))}
            >
              {say("editor.mend_text")}
            </button>
          </Notice>
        )}
        <div class="form-grid">
          <DocumentNumber
            form={form}
            path={["time_limit_s"]}
            label={say("editor.time_limit_min")}
            hint={say("editor.zero_none")}
            scale={60}
            min={0}
          />
          <DocumentFlag
            form={form}
            path={["graded"]}
            label={say("exercise_page.graded")}
            hint={say("editor.graded_hint")}
          />
        </div>
        <Part
          form={form}
          on={form.edit.at(["isolation"]) !== undefined}
          member="isolation"
          label={say("exercise_page.rubber_dam")}
          fresh="rubber_dam"
        />
      </div>
    </Card>
  );
}

function Tool({ form }: { readonly form: DocumentForm }) {
  const { edit } = form;
  const handpiece = edit.at(["handpiece"]) !== undefined;
  const cues = edit.at(["touch_cues"]) !== undefined;
  return (
    <Card title={say("editor.bur_handpiece")}>
      <div class="form">
        <BurFields form={form} path={["bur"]} />
        <OtherBurs form={form} />
        <Part
          form={form}
          on={handpiece}
          member="handpiece"
          label={say("editor.slows")}
          fresh={{ stall_un_m: 3000, tangential_permille: 300, lag_us: 50_000 }}
        >
          <DocumentNumber form={form} path={["handpiece", "stall_un_m"]} label={say("editor.stall")} scale={1000} />
          <DocumentNumber
            form={form}
            path={["handpiece", "tangential_permille"]}
            label={say("editor.tangential")}
            scale={10}
          />
          <DocumentNumber form={form} path={["handpiece", "lag_us"]} label={say("editor.lag")} scale={1000} />
        </Part>
        <Part
          form={form}
          on={cues}
          member="touch_cues"
          label={say("editor.cues")}
          fresh={{ contact_mn: 300, chatter_mn: 120, energy_uj: 250, power_uw: 800 }}
        >
          <DocumentNumber
            form={form}
            path={["touch_cues", "contact_mn"]}
            label={say("editor.knock")}
            scale={1000}
            min={0}
          />
          <DocumentNumber
            form={form}
            path={["touch_cues", "chatter_mn"]}
            label={say("editor.chatter")}
            scale={1000}
            min={0}
          />
          <DocumentNumber form={form} path={["touch_cues", "energy_uj"]} label={say("editor.energy")} whole />
          <DocumentNumber form={form} path={["touch_cues", "power_uw"]} label={say("editor.power")} whole min={0} />
        </Part>
      </div>
    </Card>
  );
}

// A part of the document that may be left out.
function Part({
  form,
  on,
  member,
  label,
  fresh,
  children,
}: {
  readonly form: DocumentForm;
  readonly on: boolean;
  readonly member: string;
  readonly label: string;
  readonly fresh: Json;
  readonly children?: ComponentChildren;
}) {
  const [id] = useState(() => `part_${member}`);
  return (
    <fieldset class="group">
      <legend>{label}</legend>
      <div class="field check">
        <input
          type="checkbox"
          id={id}
          checked={on}
          onChange={(event) => form.edit.set([member], event.currentTarget.checked ? fresh : undefined)}
        />
        <label for={id}>{say("editor.yes")}</label>
      </div>
      {on && children !== undefined && <div class="form-grid">{children}</div>}
    </fieldset>
  );
}

function Target({ form }: { readonly form: DocumentForm }) {
  const parts = form.edit.at(["target", "parts"]);
  return (
    <Card title={say("editor.to_cut")}>
      <div class="form">
        {Array.isArray(parts) && (
          <Notice tone="neutral">
            <p>{say("editor.parts", { count: parts.length })}</p>
          </Notice>
        )}
        <div class="form-grid">
          <DocumentNumber
            form={form}
            path={["target", "half_size_um", 0]}
            label={say("editor.length_md")}
            scale={kMm / 2}
          />
          <DocumentNumber
            form={form}
            path={["target", "half_size_um", 1]}
            label={say("editor.width_bl")}
            scale={kMm / 2}
          />
          <DocumentNumber form={form} path={["target", "depth_um"]} label={say("editor.depth")} scale={kMm} />
          <DocumentNumber
            form={form}
            path={["target", "leeway_side_um"]}
            label={say("editor.beyond_walls")}
            scale={kMm}
            min={0}
          />
          <DocumentNumber
            form={form}
            path={["target", "leeway_bottom_um"]}
            label={say("editor.below_floor")}
            scale={kMm}
            min={0}
          />
          <DocumentNumber
            form={form}
            path={["target", "container_um"]}
            label={say("editor.must_stay")}
            scale={kMm}
            min={0}
          />
        </div>
      </div>
    </Card>
  );
}
