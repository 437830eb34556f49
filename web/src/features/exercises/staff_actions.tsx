import { useState } from "preact/hooks";
import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { addressOf, type ApiResult } from "../../api/http";
import type { Exercise } from "../../api/types";
import { say, sayWith } from "../../base/words";
import { Notice } from "../../widgets/basics";
import { Confirm, Dialog } from "../../widgets/dialog";
import { part } from "../../widgets/part";
import { Copying } from "./copying";
import { DocumentForm } from "./document_form";

const TargetScanPart = part("target_scan", () => import("./target_scan"));

interface Props {
  readonly client: Client;
  readonly exercise: Exercise;
  readonly tag: string;
  readonly onChanged: () => void;
  readonly onOpen: (path: string) => void;
}

type Open = "copy" | "scan" | "publish" | "retire" | "delete" | "replace" | "share";

// What a teacher can do with an exercise: replace, publish or delete a draft; retire what is
// published.
export function StaffActions({ client, exercise, tag, onChanged, onOpen }: Props) {
  const [open, setOpen] = useState<Open>();
  const [done, setDone] = useState<string>();
  const close = () => setOpen(undefined);
  const confirm = async (ask: Promise<ApiResult<unknown>>, then: () => void) => {
    const result = await ask;
    if (!result.ok)
      return result.error.status === 412
        ? say("staff.changed", { reason: result.error.message })
        : result.error.message;
    then();
    return undefined;
  };
  const said = (text: string) => () => {
    setDone(text);
    onChanged();
  };
  const copy = open === "copy" && (
    <Dialog title={say("copy_exercise.dialog", { title: wordedTitle(exercise.title) })} onClose={close}>
      <Copying
        show={({ CopyForm }) => (
          <CopyForm
            client={client}
            from={exercise.id}
            onCancel={close}
            onDone={(made) => onOpen(`/editor?exercise=${made.id}`)}
          />
        )}
      />
    </Dialog>
  );
  const scan = open === "scan" && (
    <Dialog title={say("target_scan.title", { title: wordedTitle(exercise.title) })} onClose={close}>
      <TargetScanPart show={({ TargetScan }) => <TargetScan client={client} exercise={exercise} onClose={close} />} />
    </Dialog>
  );
  const copyButtons = (
    <>
      <button type="button" class="button" onClick={() => setOpen("copy")}>
        {say("copy_exercise.ask")}
      </button>
      {exercise.may.includes("scan_target") && (
        <button type="button" class="button" onClick={() => setOpen("scan")}>
          {say("target_scan.ask")}
        </button>
      )}
    </>
  );
  // Others' exercises are to read, to assign and to copy.
  if (!exercise.may.includes("change"))
    return (
      <div class="actions">
        <div class="button-row">{copyButtons}</div>
        {copy}
        {scan}
      </div>
    );
  return (
    <div class="actions">
      <div class="button-row">
        {exercise.state === "draft" && (
          <>
            <button type="button" class="button primary" onClick={() => setOpen("publish")}>
              {say("staff.publish_ask")}
            </button>
            <a class="button" href={`/editor?exercise=${exercise.id}`}>
              {say("staff.edit_draft")}
            </a>
            <button type="button" class="button" onClick={() => setOpen("replace")}>
              {say("staff.replace_ask")}
            </button>
            <button type="button" class="button" onClick={() => setOpen("delete")}>
              {say("staff.delete_ask")}
            </button>
          </>
        )}
        {exercise.state !== "draft" && (
          <a class="button" href={`/editor?exercise=${exercise.id}`}>
            {say("staff.edit_new")}
          </a>
        )}
        {exercise.state === "published" && (
          <a class="button" href={`/editor?rubric=${exercise.id}`}>
            {say("staff.rubric")}
          </a>
        )}
        {exercise.state === "published" && (
          <button type="button" class="button" onClick={() => setOpen("retire")}>
            {say("staff.retire_ask")}
          </button>
        )}
        <button type="button" class="button" onClick={() => setOpen("share")}>
          {exercise.shared ? say("staff.unshare_ask") : say("staff.share_ask")}
        </button>
        {copyButtons}
      </div>
      {copy}
      {scan}
      <div aria-live="polite">
        {done !== undefined && (
          <Notice tone="good">
            <p>{done}</p>
          </Notice>
        )}
      </div>
      {open === "publish" && (
        <Confirm
          title={say("staff.publish_title")}
          action={say("staff.publish")}
          tone="neutral"
          onClose={close}
          onConfirm={() =>
            confirm(client.post("/exercises/{id}/publish", { id: exercise.id, tag }), said(say("staff.published")))
          }
        >
          <p>{sayWith("staff.publish_text", { name: <code>{exercise.name}</code> })}</p>
        </Confirm>
      )}
      {open === "retire" && (
        <Confirm
          title={say("staff.retire_title", { title: wordedTitle(exercise.title) })}
          action={say("staff.retire")}
          onClose={close}
          onConfirm={() =>
            confirm(client.post("/exercises/{id}/retire", { id: exercise.id }), said(say("staff.retired")))
          }
        >
          <p>{sayWith("staff.retire_text", { name: <code>{exercise.name}</code> })}</p>
        </Confirm>
      )}
      {open === "share" && (
        <Confirm
          title={
            exercise.shared
              ? say("staff.unshare_title", { title: wordedTitle(exercise.title) })
              : say("staff.share_title", { title: wordedTitle(exercise.title) })
          }
          action={exercise.shared ? say("staff.unshare") : say("staff.share")}
          tone="neutral"
          onClose={close}
          onConfirm={() =>
            confirm(
              client.put("/exercises/{id}/sharing", { id: exercise.id, body: { shared: !exercise.shared } }),
              said(exercise.shared ? say("staff.private") : say("staff.shared")),
            )
          }
        >
          {exercise.shared ? (
            <p>{say("staff.unshare_text")}</p>
          ) : (
            <p>{sayWith("staff.share_text", { name: <code>{exercise.name}</code> })}</p>
          )}
        </Confirm>
      )}
      {open === "delete" && (
        <Confirm
          title={say("staff.delete_title")}
          action={say("staff.delete")}
          onClose={close}
          onConfirm={() =>
            confirm(client.delete("/exercises/{id}", { id: exercise.id, tag }), () => onOpen("/exercises"))
          }
        >
          <p>{say("staff.delete_text")}</p>
          <p>
            <a
              href={addressOf("/exercises/{id}/document", { id: exercise.id })}
              download={`${exercise.name}_draft.json`}
            >
              {say("staff.save_document")}
            </a>
          </p>
        </Confirm>
      )}
      {open === "replace" && (
        <Dialog title={say("staff.replace_title")} onClose={close}>
          <DocumentForm
            onCancel={close}
            action={say("staff.replace")}
            send={(text) => client.put("/exercises/{id}", { id: exercise.id, body: text, tag })}
            onDone={() => {
              close();
              setDone(say("staff.replaced"));
              onChanged();
            }}
          />
        </Dialog>
      )}
    </div>
  );
}
