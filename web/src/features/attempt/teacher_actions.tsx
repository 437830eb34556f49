import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { AttemptDetail } from "../../api/types";
import { awaitsRelease } from "../../widgets/attempt_state";
import { Badge, Notice } from "../../widgets/basics";

interface Props {
  readonly client: Client;
  readonly attempt: AttemptDetail;
  readonly graded: boolean;
  readonly onChanged: () => void;
}

type Outcome = { readonly tone: "good" | "bad"; readonly text: string };

// What an instructor can do with a scored attempt: release it, or make it the reference.
export function TeacherActions({ client, attempt, graded, onChanged }: Props) {
  const [naming, setNaming] = useState(false);
  const [busy, setBusy] = useState(false);
  const [outcome, setOutcome] = useState<Outcome>();

  const act = async (ask: () => Promise<{ readonly ok: boolean; readonly error?: { readonly message: string } }>, done: string) => {
    if (busy) return;
    setBusy(true);
    const result = await ask();
    setBusy(false);
    setOutcome(result.ok ? { tone: "good", text: done } : { tone: "bad", text: result.error?.message ?? "" });
    if (!result.ok) return;
    setNaming(false);
    onChanged();
  };

  return (
    <div class="actions">
      <div class="button-row">
        {attempt.released && <Badge tone="good">Score released</Badge>}
        {awaitsRelease(attempt, graded) && (
          <button type="button" class="button primary" disabled={busy}
                  onClick={() => void act(() => client.release(attempt.id), `${attempt.person.display_name} can see the score now.`)}>
            Release score
          </button>
        )}
        {attempt.is_reference ? <Badge tone="good">Reference of its exercise</Badge> : (
          <button type="button" class="button" aria-expanded={naming} onClick={() => setNaming(!naming)}>Mark as reference…</button>
        )}
      </div>
      {naming && (
        <ReferenceForm busy={busy} onCancel={() => setNaming(false)}
                       onName={(dentist) => void act(() => client.markReference(attempt.id, dentist), "The attempt is the reference of its exercise now. Earlier scores keep theirs.")} />
      )}
      <div aria-live="polite">
        {outcome !== undefined && <Notice tone={outcome.tone} title={outcome.tone === "good" ? "Done" : "Not done"}><p>{outcome.text}</p></Notice>}
      </div>
    </div>
  );
}

function ReferenceForm({ busy, onName, onCancel }:
                       { readonly busy: boolean; readonly onName: (dentist: string) => void; readonly onCancel: () => void }) {
  const [dentist, setDentist] = useState("");
  const submit = (event: Event) => {
    event.preventDefault();
    if (dentist.trim() !== "") onName(dentist.trim());
  };
  return (
    <form class="inline-form" onSubmit={submit}>
      <label for="dentist">Dentist, as to be shown with consent</label>
      <input id="dentist" type="text" required maxLength={200} value={dentist} onInput={(event) => setDentist(event.currentTarget.value)} />
      <div class="button-row">
        <button type="submit" class="button primary" disabled={busy}>Mark as reference</button>
        <button type="button" class="button" onClick={onCancel}>Cancel</button>
      </div>
    </form>
  );
}
