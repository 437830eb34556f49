import { useState } from "preact/hooks";
import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { useChange } from "../../api/use_change";
import { useRequest } from "../../api/use_request";
import { say } from "../../base/words";
import { ErrorNotice, Notice } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
import { SelectField } from "../../widgets/form";

// One of the teeth that the program can make, with its exercises.
export function BuiltinTooth({ client, onDone }: { readonly client: Client; readonly onDone: () => void }) {
  const teeth = useRequest("teeth", (signal) => client.get("/builtin-teeth", { signal }));
  const [chosen, setChosen] = useState("");
  const [put, setPut] = useState<string>();
  const change = useChange();
  if (teeth.loaded.state !== "ready") return null;
  const known = teeth.loaded.value.teeth;
  const name = chosen === "" ? (known[0]?.name ?? "") : chosen;
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() => client.post("/builtin-teeth", { body: { name } }));
    if (result?.ok !== true) return;
    setPut(say("add_tooth.added", { title: wordedTitle(result.value.title), count: result.value.exercises.length }));
    onDone();
  };
  const summary = known.find((tooth) => tooth.name === name)?.summary;
  return (
    <form class="filters" onSubmit={(event) => void submit(event)}>
      <SelectField
        label={say("add_tooth.title")}
        value={name}
        onValue={setChosen}
        hint={summary === undefined ? undefined : wordedTitle(summary)}
        options={known.map((tooth) => ({ value: tooth.name, title: tooth.name }))}
      />
      <Button busy={change.busy} blocked={needed({ [say("add_tooth.title")]: name })}>
        {change.busy ? say("add_tooth.making") : say("add_tooth.add")}
      </Button>
      {change.error !== undefined && <ErrorNotice title={say("add_tooth.not_added")} message={change.error.message} />}
      <div aria-live="polite">
        {put !== undefined && (
          <Notice tone="good">
            <p>{put}</p>
          </Notice>
        )}
      </div>
    </form>
  );
}
