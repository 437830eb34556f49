import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Annotation, Series } from "../../api/types";
import { useChange } from "../../api/use_change";
import { formatDateTime, formatMoment, formatNumber } from "../../base/format";
import { Card, Empty, ErrorNotice } from "../../widgets/basics";
import { Confirm } from "../../widgets/dialog";
import { LongTextField } from "../../widgets/form";
import type { PointMm } from "../../widgets/tooth/scene";
import { commentsOf, dropComment, keepComment } from "./comment_bank";
import { type Mark, secondsOfTick, tickOfStep } from "./moments";

const kMaxText = 4000;

interface Props {
  readonly client: Client;
  readonly attemptId: string;
  readonly personId: string;                    // who writes, and whose comments are kept
  readonly teacher: boolean;                    // may add remarks
  readonly series: Series;
  readonly marks: readonly Mark[];
  readonly chosen: string | undefined;          // id of a remark
  readonly cursor: number;
  readonly point: PointMm | undefined;          // clicked on the tooth, for the next remark
  readonly onPoint: (point: PointMm | undefined) => void;
  readonly onChoose: (mark: Mark) => void;
  readonly onChanged: () => void;
}

// What a teacher remarks at moments of an attempt and at points of the tooth.
export function AnnotationsPanel(props: Props) {
  const { marks, teacher } = props;
  return (
    <Card title="Remarks" className="annotations-card">
      {marks.length === 0
        ? <Empty>{teacher ? "No remark yet. Move the time to the moment you mean, click the picture where you mean, and write." : "Your instructor has made no remark."}</Empty>
        : <ol class="annotations">{marks.map((mark) => <li key={mark.annotation.id}><RemarkItem {...props} mark={mark} /></li>)}</ol>}
      {teacher && <NewRemark {...props} />}
    </Card>
  );
}

function RemarkItem({ client, series, mark, chosen, onChoose, onChanged }: Props & { readonly mark: Mark }) {
  const { annotation, number } = mark;
  const [mode, setMode] = useState<"read" | "edit" | "delete">("read");
  return (
    <div class={chosen === annotation.id ? "annotation chosen" : "annotation"}>
      <span class="annotation-number" aria-hidden="true">{number}</span>
      <div class="annotation-body">
        <p class="hint">
          <button type="button" class="button small quiet" onClick={() => onChoose(mark)}>
            <span class="hidden">Remark {number}: show </span>{formatMoment(secondsOfTick(series, annotation.tick))}
          </button>
          {annotation.point_um !== null && " at a point · "}{annotation.author.display_name === "" ? "Somebody whose account was erased" : annotation.author.display_name}, {formatDateTime(annotation.created_ms)}
          {annotation.edited_ms > 0 && ", edited"}
        </p>
        {mode === "edit"
          ? <EditRemark client={client} annotation={annotation} onDone={() => { setMode("read"); onChanged(); }} onCancel={() => setMode("read")} />
          : <p>{annotation.text}</p>}
        {annotation.mine && mode === "read" && (
          <div class="button-row">
            <button type="button" class="button small" onClick={() => setMode("edit")}>Edit<span class="hidden"> remark {number}</span></button>
            <button type="button" class="button small" onClick={() => setMode("delete")}>Delete…<span class="hidden"> remark {number}</span></button>
          </div>
        )}
      </div>
      {mode === "delete" && (
        <Confirm title={`Delete remark ${number}?`} action="Delete remark" onClose={() => setMode("read")}
                 onConfirm={async () => {
                   const result = await client.teaching.deleteAnnotation(annotation);
                   if (!result.ok) return result.error.message;
                   onChanged();
                   return undefined;
                 }}>
          <p class="quote">{annotation.text}</p><p>The student will not see it any more. It cannot be brought back; the audit keeps that it was there.</p>
        </Confirm>
      )}
    </div>
  );
}

function EditRemark({ client, annotation, onDone, onCancel }:
    { readonly client: Client; readonly annotation: Annotation; readonly onDone: () => void; readonly onCancel: () => void }) {
  const [text, setText] = useState(annotation.text);
  const change = useChange();
  const save = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() => client.teaching.editAnnotation(annotation, { tick: annotation.tick, point_um: annotation.point_um, text: text.trim() }));
    if (result?.ok === true) onDone();
  };
  return (
    <form class="form" onSubmit={(event) => void save(event)}>
      <LongTextField label="Remark" value={text} onValue={setText} required maxLength={kMaxText} rows={3} />
      {change.error !== undefined && <ErrorNotice title={change.error.status === 412 ? "Somebody changed it meanwhile" : "Not saved"} message={change.error.message} />}
      <div class="button-row">
        <button type="submit" class="button primary small" disabled={change.busy || text.trim() === ""}>Save</button>
        <button type="button" class="button small" onClick={onCancel}>Cancel</button>
      </div>
    </form>
  );
}

function NewRemark({ client, attemptId, personId, series, cursor, point, onPoint, onChanged }: Props) {
  const [text, setText] = useState("");
  const [kept, setKept] = useState(() => commentsOf(personId));
  const change = useChange();
  const save = async (event: Event) => {
    event.preventDefault();
    const remark = { tick: tickOfStep(series, cursor), point_um: point === undefined ? null : umOf(point), text: text.trim() };
    const result = await change.run(() => client.teaching.annotate(attemptId, remark));
    if (result?.ok !== true) return;
    setText("");
    onPoint(undefined);
    onChanged();
  };
  const anchor = series.anchor_mm[cursor];
  return (
    <form class="form new-remark" onSubmit={(event) => void save(event)}>
      <LongTextField label={`New remark at ${formatMoment(series.t_s[cursor] ?? 0)}`} value={text} onValue={setText} required maxLength={kMaxText} rows={3}
                     hint={point === undefined ? "Click the picture to tie it to a point there, or take the tool's place at this moment."
                                               : `At the point ${point.map((mm) => formatNumber(mm, 1)).join(" / ")} mm (mesial / buccal / occlusal).`} />
      {change.error !== undefined && <ErrorNotice title="Not saved" message={change.error.message} />}
      <div class="button-row">
        <button type="submit" class="button primary" disabled={change.busy || text.trim() === ""}>Add remark</button>
        {point === undefined
          ? anchor !== undefined && <button type="button" class="button" onClick={() => onPoint([anchor[0] ?? 0, anchor[1] ?? 0, anchor[2] ?? 0])}>Point at the tool</button>
          : <button type="button" class="button" onClick={() => onPoint(undefined)}>Without a point</button>}
        {text.trim() !== "" && !kept.includes(text.trim()) && <button type="button" class="button" onClick={() => setKept(keepComment(personId, text))}>Keep this comment</button>}
      </div>
      {kept.length > 0 && (
        <details>
          <summary>Kept comments ({kept.length})</summary>
          <ul class="comment-bank">
            {kept.map((comment) => (
              <li key={comment}>
                <button type="button" class="button small quiet" onClick={() => setText((now) => now.trim() === "" ? comment : `${now.trimEnd()} ${comment}`)}>{comment}</button>
                <button type="button" class="button small quiet" aria-label={`Forget “${comment}”`} onClick={() => setKept(dropComment(personId, comment))}>✕</button>
              </li>
            ))}
          </ul>
        </details>
      )}
    </form>
  );
}

function umOf(point: PointMm): [number, number, number] {
  return [Math.round(1000 * point[0]), Math.round(1000 * point[1]), Math.round(1000 * point[2])];
}
