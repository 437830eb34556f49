import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import { placedMessage } from "../../api/placed";
import type { Exercise } from "../../api/types";
import { useChange } from "../../api/use_change";
import { formatNumber } from "../../base/format";
import { say } from "../../base/words";
import { needed } from "../../widgets/button";
import { FormButtons } from "../../widgets/dialog";
import { ErrorNotice } from "../../widgets/basics";
import { FileField } from "../../widgets/form";

const kMaxBytes = 1 << 20;

// `text`: an exercise document (schemas/exercise.schema.json). Without a dry run, the answer is the draft.
export function putDraft(client: Client, text: string) {
  return client.post("/exercises", { body: text }) as Promise<ApiResult<Exercise>>;
}

interface Props {
  readonly action: string;
  readonly send: (text: string) => Promise<ApiResult<Exercise>>;
  readonly onDone: (exercise: Exercise) => void;
  readonly onCancel: () => void;
}

// An exercise document from a file. The server checks it whole; what is wrong is shown with the
// place in the document.
export function DocumentForm({ action, send, onDone, onCancel }: Props) {
  const [file, setFile] = useState<File>();
  const change = useChange();
  const tooLarge = file !== undefined && file.size > kMaxBytes;
  const submit = async (event: Event) => {
    event.preventDefault();
    if (file === undefined || tooLarge) return;
    const text = await file.text();
    const result = await change.run(() => send(text));
    if (result?.ok === true) onDone(result.value);
  };
  return (
    <form class="form" onSubmit={(event) => void submit(event)}>
      <FileField
        label={say("document.file")}
        accept=".json,application/json"
        onFile={(chosen) => {
          setFile(chosen);
          change.clear();
        }}
        hint={say("document.file_hint")}
        problem={
          tooLarge
            ? say("document.too_large", { found: formatNumber(file.size, 0), most: formatNumber(kMaxBytes, 0) })
            : undefined
        }
      />
      {change.error !== undefined && (
        <ErrorNotice
          title={change.error.code === "invalid_input" ? say("document.not_right") : say("common.not_saved")}
          message={placedMessage(change.error)}
        />
      )}
      <FormButtons
        action={action}
        busy={change.busy}
        blocked={needed({ [say("document.file")]: file !== undefined && !tooLarge })}
        onCancel={onCancel}
      />
    </form>
  );
}
