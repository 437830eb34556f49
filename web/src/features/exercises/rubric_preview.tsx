import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { RubricPreview } from "../../api/types";
import { useChange } from "../../api/use_change";
import type { Json } from "../../base/document";
import { formatScore, plural } from "../../base/format";
import { placedMessage } from "../../api/http";
import { Badge, Card, Empty, ErrorNotice, Notice } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import { Tenths } from "../../widgets/tenths";

const kShown = 20;

// What a rubric would make of the attempts that were scored already; nothing is changed by looking.
export function RubricPreviewCard({ client, exercise, rubric }: { readonly client: Client; readonly exercise: string; readonly rubric: Json }) {
  const change = useChange();
  const [preview, setPreview] = useState<{ readonly of: Json; readonly value: RubricPreview }>();
  const look = async () => {
    const result = await change.run(() => client.teaching.previewRubric(exercise, rubric));
    if (result?.ok === true) setPreview({ of: rubric, value: result.value });
  };
  return (
    <Card title="Past attempts under this rubric">
      <p class="hint">Points are given anew from what was measured. No score changes by looking.</p>
      <div><button type="button" class="button" disabled={change.busy} onClick={() => void look()}>Look at past attempts</button></div>
      {change.error !== undefined && <ErrorNotice title="They could not be looked at" message={placedMessage(change.error)} />}
      {preview !== undefined && (
        <div class={preview.of === rubric ? "stack" : "stack stale"} aria-live="polite">
          {preview.of !== rubric && <Notice tone="warning"><p>The rubric was changed since. Look again.</p></Notice>}
          <Outcome preview={preview.value} />
        </div>
      )}
    </Card>
  );
}

function Outcome({ preview }: { readonly preview: RubricPreview }) {
  const { attempts } = preview;
  if (attempts.length === 0) return <Empty>No attempt of yours to see was scored yet.</Empty>;
  const moved = attempts.filter((attempt) => attempt.after !== null && attempt.after.toFixed(1) !== attempt.before.toFixed(1));
  return (
    <>
      <dl class="facts">
        <div><dt>Attempts</dt><dd>{attempts.length}</dd></div>
        <div><dt>Would rise</dt><dd>{preview.raised}</dd></div>
        <div><dt>Would fall</dt><dd>{preview.lowered}</dd></div>
        <div><dt>Mean, now and then</dt><dd>{formatScore(preview.mean_before)} → {formatScore(preview.mean_after)}</dd></div>
        <div><dt>Scores now</dt><dd><Tenths counts={preview.histogram_before} what="scores now" /></dd></div>
        <div><dt>Scores then</dt><dd><Tenths counts={preview.histogram_after} what="scores then" /></dd></div>
      </dl>
      {preview.problems > 0 && <p class="hint">Of {plural(preview.problems, "attempt")} it cannot be told without scoring them again.</p>}
      {(preview.warnings ?? []).map((warning) => <Notice key={warning} tone="warning"><p>{warning}</p></Notice>)}
      {moved.length > 0 && (
        <DataTable label="Attempts that would change most" items={moved.slice(0, kShown)} rowKey={(attempt) => attempt.attempt_id} dense columns={[
          { title: "Student", cell: (attempt) => <a href={`/attempts/${attempt.attempt_id}`}>{attempt.person.display_name}</a> },
          { title: "Now", number: true, cell: (attempt) => formatScore(attempt.before) },
          { title: "Then", number: true, cell: (attempt) => formatScore(attempt.after) },
          { title: "Released", cell: (attempt) => attempt.released ? <Badge tone="warning">would be withdrawn</Badge> : "no" },
        ]} />
      )}
      {moved.length > kShown && <p class="hint">And {plural(moved.length - kShown, "attempt")} more.</p>}
    </>
  );
}
