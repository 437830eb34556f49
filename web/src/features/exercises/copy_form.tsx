import { useState } from "preact/hooks";
import { exerciseTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { placeText } from "../../api/place_text";
import { placedMessage } from "../../api/placed";
import type { Exercise } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useRequest } from "../../api/use_request";
import { say } from "../../base/words";
import { ErrorNotice, Waits } from "../../widgets/basics";
import { needed } from "../../widgets/button";
import { FormButtons } from "../../widgets/dialog";
import { SelectField, TextField } from "../../widgets/form";
import { putDraft } from "./document_form";
import { copied, isName, nameFor } from "./copied";

interface Props {
  readonly client: Client;
  readonly from?: string | undefined; // id of the exercise to copy; undefined: it is chosen
  readonly onDone: (exercise: Exercise) => void;
  readonly onCancel: () => void;
}

// A draft of one's own, made of an exercise that is there.
export function CopyForm({ client, from, onDone, onCancel }: Props) {
  const { loaded, reload } = useRequest("published", (signal) =>
    client.all("/exercises", { state: "published", signal }),
  );
  const [chosen, setChosen] = useState(from);
  const [title, setTitle] = useState("");
  const [typed, setTyped] = useState<string>(); // undefined: the name follows the title
  const change = useChange();
  if (loaded.state !== "ready")
    return (
      <Waits loaded={loaded} reload={reload} what={say("loading.exercises")} failed={say("exercise_list.failed")} />
    );
  const source = chosen ?? loaded.value[0]?.id;
  const name = typed ?? nameFor(title);
  const submit = async (event: Event) => {
    event.preventDefault();
    if (source === undefined) return;
    const result = await change.run(async () => {
      const document = await client.get("/exercises/{id}/document", { id: source });
      return document.ok ? putDraft(client, JSON.stringify(copied(document.value, name, title.trim()))) : document;
    });
    if (result?.ok === true) onDone(result.value);
  };
  return (
    <form class="form" onSubmit={(event) => void submit(event)}>
      {from === undefined && (
        <SelectField
          label={say("copy_exercise.from")}
          hint={say("copy_exercise.from_hint")}
          value={source ?? ""}
          options={loaded.value.map((exercise) => ({ value: exercise.id, title: exerciseTitle(exercise) }))}
          onValue={setChosen}
        />
      )}
      <TextField
        label={say("copy_exercise.title")}
        hint={say("copy_exercise.title_hint")}
        value={title}
        onValue={setTitle}
        required
        maxLength={200}
      />
      <TextField
        label={say("account.name")}
        hint={say("copy_exercise.name_hint")}
        problem={name !== "" && !isName(name) ? say("copy_exercise.name_problem") : undefined}
        value={name}
        onValue={setTyped}
        required
        maxLength={64}
      />
      {change.error !== undefined && (
        <ErrorNotice
          title={say("common.not_saved")}
          message={placedMessage(change.error, placeText(change.error.field))}
        />
      )}
      <FormButtons
        action={say("copy_exercise.do")}
        busy={change.busy}
        blocked={needed({
          [say("copy_exercise.from")]: source,
          [say("copy_exercise.title")]: title.trim(),
          [say("account.name")]: isName(name),
        })}
        onCancel={onCancel}
      />
    </form>
  );
}
