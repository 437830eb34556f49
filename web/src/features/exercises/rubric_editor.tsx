import { useMemo, useState } from "preact/hooks";
import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { Tagged } from "../../api/http";
import type { Exercise, RubricVersion, ScoringMetric } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useCheck } from "../../api/use_check";
import { useRequest } from "../../api/use_request";
import type { Json } from "../../base/document";
import { formatDateTime } from "../../base/format";
import { ok } from "../../base/result";
import { say } from "../../base/words";
import { AnywayField, useAnyway } from "../../widgets/anyway";
import { Card, ErrorNotice, PageTitle, Waits } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { DocumentChanges } from "../../widgets/document_changes";
import { type DocumentForm, stillWrong } from "../../widgets/document_fields";
import { EditBar } from "../../widgets/edit_bar";
import { LongTextField, SelectField } from "../../widgets/form";
import { useDocument } from "../../widgets/use_document";
import { placeTitle, rubricProblems } from "./editor_text";
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
  readonly rubrics: Tagged<readonly RubricVersion[]>; // newest first
  readonly metrics: readonly ScoringMetric[];
}

// The rubric of a published exercise, corrected: the exercise stays, scores change when they are
// made again.
export function RubricEditorPage({ client, id, onOpen }: Props) {
  const { loaded, reload } = useRequest(`rubric ${id}`, async (signal) => {
    const [exercise, rubrics, metrics] = await Promise.all([
      client.tagged("GET", "/exercises/{id}", { id, signal }),
      client.tagged("GET", "/exercises/{id}/rubrics", { id, signal }),
      client.get("/scoring-metrics", { signal }),
    ]);
    if (!exercise.ok) return exercise;
    if (!rubrics.ok) return rubrics;
    return metrics.ok
      ? ok<Read>({
          exercise: exercise.value.value,
          rubrics: { value: rubrics.value.value.rubrics, tag: rubrics.value.tag },
          metrics: metrics.value.metrics,
        })
      : metrics;
  });
  if (loaded.state !== "ready")
    return (
      <Waits loaded={loaded} reload={reload} what={say("loading.rubric")} failed={say("rubric.failed")}>
        <PageTitle document={say("exercise_page.rubric")}>{say("rubric.correct")}</PageTitle>
      </Waits>
    );
  return <Editor key={loaded.value.rubrics.tag} client={client} read={loaded.value} onOpen={onOpen} onNewer={reload} />;
}

function Editor({
  client,
  read: { exercise, rubrics, metrics },
  onOpen,
  onNewer,
}: {
  readonly client: Client;
  readonly read: Read;
  readonly onOpen: (path: string) => void;
  readonly onNewer: () => void;
}) {
  const [counting] = rubrics.value;
  const document = (counting?.document as unknown as Json) ?? null;
  const edit = useDocument(`rubric ${exercise.id}`, document);
  const check = useCheck(JSON.stringify(edit.now), (text, signal) =>
    client.post("/exercises/{id}/rubrics/preview", { id: exercise.id, attempts: false, body: text, signal }),
  );
  const own = useMemo(() => rubricProblems(edit.now, []), [edit.now]);
  const form: DocumentForm = { edit, wrong: stillWrong(check, edit.now), own };
  const [reason, setReason] = useState("");
  const [against, setAgainst] = useState(String(counting?.version ?? 1));
  const change = useChange();
  const anyway = useAnyway(change.error, JSON.stringify(edit.now));
  const publish = async () => {
    const result = await change.run(() =>
      client.post("/exercises/{id}/rubrics", {
        id: exercise.id,
        body: { reason: reason.trim(), rubric: edit.now as never, anyway: anyway.reason || undefined },
        tag: rubrics.tag,
      }),
    );
    if (result?.ok !== true) return;
    edit.forget();
    onOpen(`/exercises/${exercise.id}`);
  };
  const compared = rubrics.value.find((rubric) => String(rubric.version) === against);
  const why = !exercise.may.includes("change")
    ? say("rubric.may_not")
    : check.error !== undefined || own.size > 0
      ? say("rubric.mend_first")
      : !edit.dirty
        ? say("rubric.nothing_changed")
        : reason.trim() === "" || anyway.missing
          ? say("rubric.reason_first")
          : undefined;
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href={`/exercises/${exercise.id}`}>{wordedTitle(exercise.title)}</a>
      </nav>
      <PageTitle document={say("rubric.of", { title: wordedTitle(exercise.title) })}>
        {say("rubric.of_version", { title: wordedTitle(exercise.title), version: versionText(exercise) })}
      </PageTitle>
      <EditBar edit={edit} state={stateText(check, edit.dirty, own.size > 0)}>
        <Button busy={change.busy || check.busy} blocked={why} onClick={() => void publish()}>
          {say(anyway.asked ? "rubric.publish_anyway" : "rubric.publish")}
        </Button>
      </EditBar>
      <Problem check={check} form={form} />
      {change.error !== undefined &&
        (change.error.status === 412 ? (
          <ErrorNotice title={say("rubric.changed")} message={say("rubric.changed_text")} onRetry={onNewer} />
        ) : (
          <ErrorNotice title={say("rubric.not_published")} message={change.error.message} />
        ))}
      <div class="editor">
        <div class="stack">
          <Card title={say("exercise_page.scored")}>
            <RubricFields form={form} path={[]} metrics={metrics} />
          </Card>
        </div>
        <div class="stack editor-side">
          <Card title={say("rubric.correction")}>
            <LongTextField
              label={say("common.reason")}
              hint={say("rubric.reason_hint")}
              value={reason}
              onValue={setReason}
              maxLength={1000}
              rows={2}
            />
            <AnywayField anyway={anyway} />
          </Card>
          <Card title={say("version.title")}>
            <SelectField
              label={say("rubric.compare")}
              value={against}
              onValue={setAgainst}
              options={rubrics.value.map((rubric, i) => ({
                value: String(rubric.version),
                title: versionTitle(rubric, i === 0),
              }))}
            />
            {compared !== undefined && (
              <DocumentChanges
                label={say("rubric.changes")}
                before={withoutVersion(compared.document as unknown as Json)}
                after={withoutVersion(edit.now)}
                beforeTitle={say("version.title_number", { number: String(compared.version) })}
                afterTitle={say("editor.here")}
                titleOf={(item) => placeTitle(item, edit.now)}
              />
            )}
          </Card>
          <RubricPreviewCard client={client} exercise={exercise.id} rubric={edit.now} />
        </div>
      </div>
    </>
  );
}

function versionTitle({ version, published_ms: publishedMs, reason }: RubricVersion, counts: boolean): string {
  const told = { number: String(version), since: formatDateTime(publishedMs) };
  if (reason === "") return say(counts ? "rubric.version_counts" : "rubric.version", told);
  return say(counts ? "rubric.version_counts_reason" : "rubric.version_reason", { ...told, reason });
}

// The server numbers them.
function withoutVersion(document: Json): Json {
  const { version: _version, ...rest } = document as { readonly [name: string]: Json };
  return rest;
}
