import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { RubricPreview } from "../../api/types";
import { useChange } from "../../api/use_change";
import type { Json } from "../../base/document";
import { formatScore } from "../../base/format";
import { say } from "../../base/words";
import { placeText } from "../../api/place_text";
import { placedMessage } from "../../api/placed";
import { Badge, Card, Empty, ErrorNotice, Notice } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import { Tenths } from "../../widgets/tenths";

const kShown = 20;

// What a rubric would make of the attempts that were scored already; nothing is changed by looking.
export function RubricPreviewCard({
  client,
  exercise,
  rubric,
}: {
  readonly client: Client;
  readonly exercise: string;
  readonly rubric: Json;
}) {
  const change = useChange();
  const [preview, setPreview] = useState<{ readonly of: Json; readonly value: RubricPreview }>();
  const look = async () => {
    const result = await change.run(() =>
      client.post("/exercises/{id}/rubrics/preview", { id: exercise, body: JSON.stringify(rubric) }),
    );
    if (result?.ok === true) setPreview({ of: rubric, value: result.value });
  };
  return (
    <Card title={say("preview.title")}>
      <p class="hint">{say("preview.hint")}</p>
      <div>
        <button type="button" class="button" disabled={change.busy} onClick={() => void look()}>
          {say("preview.look")}
        </button>
      </div>
      {change.error !== undefined && (
        <ErrorNotice
          title={say("preview.failed")}
          message={placedMessage(change.error, placeText(change.error.field))}
        />
      )}
      {preview !== undefined && (
        <div class={preview.of === rubric ? "stack" : "stack stale"} aria-live="polite">
          {preview.of !== rubric && (
            <Notice tone="warning">
              <p>{say("preview.stale")}</p>
            </Notice>
          )}
          <Outcome preview={preview.value} />
        </div>
      )}
    </Card>
  );
}

function Outcome({ preview }: { readonly preview: RubricPreview }) {
  const { attempts } = preview;
  if (attempts.length === 0) return <Empty>{say("preview.none")}</Empty>;
  const moved = attempts.filter(
    (attempt) => attempt.after !== null && attempt.after.toFixed(1) !== attempt.before.toFixed(1),
  );
  return (
    <>
      <dl class="facts">
        <div>
          <dt>{say("nav.attempts")}</dt>
          <dd>{attempts.length}</dd>
        </div>
        <div>
          <dt>{say("preview.rise")}</dt>
          <dd>{preview.raised}</dd>
        </div>
        <div>
          <dt>{say("preview.fall")}</dt>
          <dd>{preview.lowered}</dd>
        </div>
        <div>
          <dt>{say("preview.mean")}</dt>
          <dd>
            {formatScore(preview.mean_before)} → {formatScore(preview.mean_after)}
          </dd>
        </div>
        <div>
          <dt>{say("preview.now")}</dt>
          <dd>
            <Tenths counts={preview.histogram_before} what={say("preview.now")} />
          </dd>
        </div>
        <div>
          <dt>{say("preview.then")}</dt>
          <dd>
            <Tenths counts={preview.histogram_after} what={say("preview.then")} />
          </dd>
        </div>
      </dl>
      {preview.problems > 0 && <p class="hint">{say("preview.unknown", { count: preview.problems })}</p>}
      {(preview.warnings ?? []).map((warning) => (
        <Notice key={warning} tone="warning">
          <p>{warning}</p>
        </Notice>
      ))}
      {moved.length > 0 && (
        <DataTable
          label={say("preview.most")}
          items={moved.slice(0, kShown)}
          rowKey={(attempt) => attempt.attempt_id}
          dense
          columns={[
            {
              title: say("common.student"),
              cell: (attempt) => <a href={`/attempts/${attempt.attempt_id}`}>{attempt.person.display_name}</a>,
            },
            { title: say("preview.now_short"), number: true, cell: (attempt) => formatScore(attempt.before) },
            { title: say("preview.then_short"), number: true, cell: (attempt) => formatScore(attempt.after) },
            {
              title: say("grading.released"),
              cell: (attempt) =>
                attempt.released ? <Badge tone="warning">{say("preview.withdrawn")}</Badge> : say("common.no"),
            },
          ]}
        />
      )}
      {moved.length > kShown && <p class="hint">{say("preview.more", { count: moved.length - kShown })}</p>}
    </>
  );
}
