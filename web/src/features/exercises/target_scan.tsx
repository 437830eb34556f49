import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Exercise } from "../../api/types";
import { say } from "../../base/words";
import { Notice } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
import { CheckField, TextField } from "../../widgets/form";
import { Findings, useMeshUpload } from "./mesh_upload";

interface Props {
  readonly client: Client;
  readonly exercise: Exercise; // of the tooth that was prepared
  readonly onClose: () => void;
}

// A scan of an exercise's tooth that a dentist prepared becomes the target of a draft.
export function TargetScan({ client, exercise, onClose }: Props) {
  const mesh = useMeshUpload(client);
  const [title, setTitle] = useState("");
  const [placed, setPlaced] = useState(false);
  const { file, now, busy, problems } = mesh;
  const draft = now?.state === "done" ? now.tooth?.exercises[0] : undefined;
  if (now !== undefined && draft !== undefined)
    return (
      <>
        <Notice tone="good" title={draft.title}>
          <p>{say("target_scan.done")}</p>
        </Notice>
        <Findings lines={now.findings} />
        <div class="button-row">
          <button type="button" class="button" onClick={onClose}>
            {say("common.close")}
          </button>
          <a class="button primary" href={`/exercises/${draft.id}`}>
            {say("target_scan.open")}
          </a>
        </div>
      </>
    );
  const submit = (event: Event) => {
    event.preventDefault();
    void mesh.send({ title: title.trim(), prepared_of: exercise.id, placed });
  };
  return (
    <form class="form" onSubmit={submit}>
      <p>{say("target_scan.text")}</p>
      {mesh.fields(say("target_scan.file"))}
      <TextField label={say("account.name")} value={title} onValue={setTitle} required maxLength={200} />
      <CheckField
        label={say("target_scan.placed")}
        hint={say("target_scan.placed_hint")}
        value={placed}
        onValue={setPlaced}
      />
      {problems}
      <div class="button-row">
        <button type="button" class="button" onClick={onClose}>
          {say("common.cancel")}
        </button>
        <Button busy={busy} blocked={needed({ [say("target_scan.file")]: file, [say("account.name")]: title.trim() })}>
          {say("target_scan.make")}
        </Button>
      </div>
    </form>
  );
}
