import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import type { Exercise } from "../../api/types";
import { Notice } from "../../widgets/basics";
import { Confirm, Dialog } from "../../widgets/dialog";
import { DocumentForm } from "./document_form";

interface Props {
  readonly client: Client;
  readonly exercise: Exercise;
  readonly tag: string;
  readonly onChanged: () => void;
  readonly onOpen: (path: string) => void;
}

type Open = "publish" | "retire" | "delete" | "replace" | "share";

// What a teacher can do with an exercise: replace, publish or delete a draft; retire what is published.
export function StaffActions({ client, exercise, tag, onChanged, onOpen }: Props) {
  const [open, setOpen] = useState<Open>();
  const [done, setDone] = useState<string>();
  const close = () => setOpen(undefined);
  const { teaching } = client;
  const confirm = async (ask: Promise<ApiResult<unknown>>, then: () => void) => {
    const result = await ask;
    if (!result.ok) return result.error.status === 412 ? `Somebody changed it meanwhile: load the page again and look at it first. ${result.error.message}` : result.error.message;
    then();
    return undefined;
  };
  const said = (text: string) => () => {
    setDone(text);
    onChanged();
  };
  // Others' exercises are to read and to assign.
  if (!exercise.may.includes("change")) return null;
  return (
    <div class="actions">
      <div class="button-row">
        {exercise.state === "draft" && (
          <>
            <button type="button" class="button primary" onClick={() => setOpen("publish")}>Publish…</button>
            <a class="button" href={`/editor?exercise=${exercise.id}`}>Edit the draft</a>
            <button type="button" class="button" onClick={() => setOpen("replace")}>Replace the document…</button>
            <button type="button" class="button" onClick={() => setOpen("delete")}>Delete the draft…</button>
          </>
        )}
        {exercise.state !== "draft" && <a class="button" href={`/editor?exercise=${exercise.id}`}>Edit as a new draft</a>}
        {exercise.state === "published" && <a class="button" href={`/editor?rubric=${exercise.id}`}>Correct the rubric</a>}
        {exercise.state === "published" && <button type="button" class="button" onClick={() => setOpen("retire")}>Retire…</button>}
        <button type="button" class="button" onClick={() => setOpen("share")}>{exercise.shared ? "Stop sharing…" : "Share…"}</button>
      </div>
      <div aria-live="polite">{done !== undefined && <Notice tone="good"><p>{done}</p></Notice>}</div>
      {open === "publish" && (
        <Confirm title="Publish this draft?" action="Publish" tone="neutral" onClose={close}
                 onConfirm={() => confirm(teaching.publish(exercise.id, tag), said("Published. It can be assigned now."))}>
          <p>It becomes the next version of <code>{exercise.name}</code> and never changes again. Assignments stay with the version they have until somebody moves them.</p>
        </Confirm>
      )}
      {open === "retire" && (
        <Confirm title={`Retire ${exercise.title}?`} action="Retire" onClose={close}
                 onConfirm={() => confirm(teaching.retire(exercise.id), said("Retired."))}>
          <p>No version of <code>{exercise.name}</code> is offered any more, also where it is assigned. Attempts and scores stay. Publishing a new version brings it back.</p>
        </Confirm>
      )}
      {open === "share" && (
        <Confirm title={exercise.shared ? `Stop sharing ${exercise.title}?` : `Share ${exercise.title}?`} action={exercise.shared ? "Stop sharing" : "Share"} tone="neutral" onClose={close}
                 onConfirm={() => confirm(teaching.share(exercise.id, { shared: !exercise.shared }), said(exercise.shared ? "Private now." : "Shared."))}>
          {exercise.shared
            ? <p>Other instructors do not find it any more. What they have assigned goes on.</p>
            : <p>Other instructors can read <code>{exercise.name}</code> and assign it. They cannot change or retire it.</p>}
        </Confirm>
      )}
      {open === "delete" && (
        <Confirm title="Delete this draft?" action="Delete the draft" onClose={close}
                 onConfirm={() => confirm(teaching.deleteDraft(exercise.id, tag), () => onOpen("/exercises"))}>
          <p>It cannot be brought back. Save its document first if you may need it.</p>
          <p><a href={teaching.documentAddress(exercise.id)} download={`${exercise.name}_draft.json`}>Save the document</a></p>
        </Confirm>
      )}
      {open === "replace" && (
        <Dialog title="Replace the document of this draft" onClose={close}>
          <DocumentForm onCancel={close} action="Replace" send={(text) => teaching.replaceDraft(exercise.id, text, tag)}
                        onDone={() => { close(); setDone("Replaced."); onChanged(); }} />
        </Dialog>
      )}
    </div>
  );
}
