import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { failed, seen } from "../../api/http";
import { useSavedTexts, withText } from "../../api/saved_texts";
import { fromScene } from "../../api/tooth_number";
import type { Annotation, Series } from "../../api/types";
import { useChange } from "../../api/use_change";
import { keepDraft } from "../../base/drafts";
import { formatDateTime, formatMoment, formatNumber } from "../../base/format";
import { say } from "../../base/words";
import { Brief, Card, Empty, ErrorNotice } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
import { Confirm } from "../../widgets/dialog";
import { LongTextField } from "../../widgets/form";
import { SavedTextList, SaveText } from "../../widgets/saved_texts";
import type { PointMm } from "../../tooth/messages";
import { useDraft } from "../../widgets/use_draft";
import { type Mark, secondsOfTick, tickAt } from "./moments";
import { remarkTo, type Review } from "./use_review";

const kMaxText = 4000;

interface Props {
  readonly review: Review;
  readonly series: Series;
}

// What a teacher remarks at moments of an attempt and at points of the tooth.
export function AnnotationsPanel({ review, series }: Props) {
  const { marks, annotates } = review;
  return (
    <Card title={say("remarks.title")} className="annotations-card">
      {marks.length === 0 ? (
        <Empty>{annotates ? say("remarks.none_staff") : say("remarks.none")}</Empty>
      ) : (
        <ol class="annotations">
          {marks.map((mark) => (
            <li key={mark.annotation.id}>
              <RemarkItem review={review} series={series} mark={mark} />
            </li>
          ))}
        </ol>
      )}
      {annotates && <NewRemark review={review} series={series} />}
    </Card>
  );
}

function RemarkItem({ review, series, mark }: Props & { readonly mark: Mark }) {
  const { client, chosen, choose, remarks } = review;
  const { annotation, number } = mark;
  const [mode, setMode] = useState<"read" | "edit" | "delete">("read");
  const again = useRef<HTMLButtonElement>(null);
  const wasEdited = useRef(false);
  // The form had the focus and has gone, so the focus returns to the button that opened it.
  useEffect(() => {
    if (wasEdited.current && mode === "read") again.current?.focus();
    wasEdited.current = mode === "edit";
  }, [mode]);
  return (
    <div class={chosen === annotation.id ? "annotation chosen" : "annotation"}>
      <span class="annotation-number" aria-hidden="true">
        {number}
      </span>
      <div class="annotation-body">
        <p class="hint">
          <button type="button" class="button small quiet" onClick={() => choose(mark)}>
            <span class="hidden">{say("remarks.show", { number: String(number) })} </span>
            {formatMoment(secondsOfTick(series, annotation.tick))}
          </button>{" "}
          {annotation.point_um !== null && <>{say("remarks.at_a_point")} </>}
          {annotation.to_chair && <>{say("remarks.to_chair")} </>}
          {byline(annotation)}
        </p>
        {mode === "edit" ? (
          <EditRemark
            client={client}
            annotation={annotation}
            onDone={() => {
              setMode("read");
              remarks.reload();
            }}
            onCancel={() => setMode("read")}
          />
        ) : (
          <p>{annotation.text}</p>
        )}
        {annotation.mine && mode === "read" && (
          <div class="button-row">
            <button type="button" class="button small" ref={again} onClick={() => setMode("edit")}>
              <Brief shown={say("remarks.edit")} full={say("remarks.edit_which", { number: String(number) })} />
            </button>
            <button type="button" class="button small" onClick={() => setMode("delete")}>
              <Brief shown={say("remarks.delete_ask")} full={say("remarks.delete_which", { number: String(number) })} />
            </button>
          </div>
        )}
      </div>
      {mode === "delete" && (
        <Confirm
          title={say("remarks.delete_title", { number: String(number) })}
          action={say("remarks.delete")}
          onClose={() => setMode("read")}
          onConfirm={() => failed(client.delete("/annotations/{id}", seen(annotation)), remarks.reload)}
        >
          <p class="quote">{annotation.text}</p>
          <p>{say("remarks.delete_text")}</p>
        </Confirm>
      )}
    </div>
  );
}

function byline({ author, created_ms: createdMs, edited_ms: editedMs }: Annotation): string {
  const told = {
    author: author.display_name === "" ? say("remarks.erased") : author.display_name,
    when: formatDateTime(createdMs),
  };
  return editedMs > 0 ? say("remarks.by_edited", told) : say("remarks.by", told);
}

function EditRemark({
  client,
  annotation,
  onDone,
  onCancel,
}: {
  readonly client: Client;
  readonly annotation: Annotation;
  readonly onDone: () => void;
  readonly onCancel: () => void;
}) {
  const [text, setText, forget] = useDraft(`edit ${annotation.id}`, annotation.text);
  const change = useChange();
  const save = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() =>
      client.put("/annotations/{id}", {
        ...seen(annotation),
        body: { tick: annotation.tick, point_um: annotation.point_um, text: text.trim() },
      }),
    );
    if (result?.ok !== true) return;
    forget();
    onDone();
  };
  return (
    <form class="form" onSubmit={(event) => void save(event)}>
      <LongTextField label={say("remarks.one")} value={text} onValue={setText} required maxLength={kMaxText} rows={3} />
      {change.error !== undefined && (
        <ErrorNotice
          title={change.error.status === 412 ? say("conflict.title") : say("common.not_saved")}
          message={change.error.message}
        />
      )}
      <div class="button-row">
        <Button kind="primary small" busy={change.busy} blocked={needed({ [say("chair.remark")]: text.trim() })}>
          {say("common.save")}
        </Button>
        <button
          type="button"
          class="button small"
          onClick={() => {
            forget();
            onCancel();
          }}
        >
          {say("common.cancel")}
        </button>
      </div>
    </form>
  );
}

// The remark that is being written to this attempt, with its point and moment: all of it is there again after
// another attempt, a reload and a new session. Kept before the next key is taken: whoever types and leaves at once
// keeps the last letter.
function useRemarkDraft({ attempt, draft, point, moved, momentS }: Review) {
  const what = remarkTo(attempt.id);
  const [text, setText] = useState(draft?.text ?? "");
  useLayoutEffect(() => {
    keepDraft(what, { text, point, seconds: moved ? momentS : undefined });
  }, [what, text, point, moved, momentS]);
  return [text, setText] as const;
}

function NewRemark({ review, series }: Props) {
  const { client, attempt, anatomy, momentS, cursor, point, setPoint, remarks } = review;
  const [text, setText] = useRemarkDraft(review);
  const saved = useSavedTexts(client);
  const change = useChange();
  const form = useRef<HTMLFormElement>(null);
  const save = async (event: Event) => {
    event.preventDefault();
    const remark = {
      tick: tickAt(series, momentS),
      point_um: point === undefined ? null : umOf(point),
      text: text.trim(),
    };
    const result = await change.run(() => client.post("/attempts/{id}/annotations", { id: attempt.id, body: remark }));
    // While it is sent the button cannot hold the focus: who did not go elsewhere writes on.
    if (document.activeElement === document.body || form.current?.contains(document.activeElement) === true)
      form.current?.querySelector("textarea")?.focus();
    if (result?.ok !== true) return;
    setText("");
    setPoint(undefined);
    remarks.reload();
  };
  const anchor = series.anchor_mm[cursor];
  return (
    <form class="form new-remark" ref={form} onSubmit={(event) => void save(event)}>
      <LongTextField
        label={say("remarks.new", { moment: formatMoment(momentS) })}
        value={text}
        onValue={setText}
        required
        maxLength={kMaxText}
        rows={3}
        hint={
          point === undefined
            ? say("remarks.click")
            : say("remarks.at_point", {
                point: (anatomy === undefined ? point : fromScene(anatomy, point))
                  .map((mm) => formatNumber(mm, 1))
                  .join(" / "),
              })
        }
      />
      <p class="hint">{say("remarks.keys")}</p>
      {change.error !== undefined && <ErrorNotice title={say("common.not_saved")} message={change.error.message} />}
      <div class="button-row">
        <Button busy={change.busy} blocked={needed({ [say("chair.remark")]: text.trim() })}>
          {say("remarks.add")}
        </Button>
        {point === undefined ? (
          anchor !== undefined && (
            <button
              type="button"
              class="button"
              onClick={() => setPoint([anchor[0] ?? 0, anchor[1] ?? 0, anchor[2] ?? 0])}
            >
              {say("remarks.at_tool")}
            </button>
          )
        ) : (
          <button type="button" class="button" onClick={() => setPoint(undefined)}>
            {say("remarks.no_point")}
          </button>
        )}
        <SaveText saved={saved} text={text} />
      </div>
      <SavedTextList saved={saved} onUse={(words) => setText(withText(text, words))} />
    </form>
  );
}

function umOf(point: PointMm): [number, number, number] {
  return [Math.round(1000 * point[0]), Math.round(1000 * point[1]), Math.round(1000 * point[2])];
}
