import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { useChange } from "../../api/use_change";
import { useRequest } from "../../api/use_request";
import { say } from "../../base/words";
import { Card, ErrorNotice, Notice } from "../../widgets/basics";
import { TextField } from "../../widgets/form";

// The PIN with which instructors sign exams at a chair. It is never shown again.
// What is wrong with a PIN, by the field of the answer.
const kRefusals: Readonly<Record<string, "refused" | "repeats" | "run" | "date">> = {
  pin: "refused",
  pin_repeats: "repeats",
  pin_run: "run",
  pin_date: "date",
};

export function PinCard({ client }: { readonly client: Client }) {
  const [pin, setPin] = useState("");
  const [chosen, setChosen] = useState(false);
  const change = useChange();
  // Asked for when the card is opened: wrong PINs are typed at chairs, while this page is open too.
  const { loaded, reload } = useRequest("pin", () => client.currentSession());
  const locked = loaded.state === "ready" && loaded.value.pin_locked;
  const refusal = kRefusals[change.error?.field ?? ""];
  const submit = async (event: Event) => {
    event.preventDefault();
    setChosen(false);
    const result = await change.run(() => client.put("/session/pin", { body: { pin } }));
    if (result?.ok !== true) return;
    setPin("");
    setChosen(true);
    reload();
  };
  return (
    <Card title={say("account.pin")}>
      {locked && !chosen && (
        <Notice tone="warning" title={say("account.pin_locked")}>
          <p>{say("account.pin_locked_text")}</p>
        </Notice>
      )}
      <form class="form narrow" onSubmit={(event) => void submit(event)}>
        <TextField
          label={say("account.new_pin")}
          secret
          autocomplete="off"
          required
          maxLength={12}
          value={pin}
          onValue={setPin}
          hint={say("account.pin_hint")}
          problem={refusal === undefined ? undefined : say(`account.pin_${refusal}`)}
        />
        {change.error !== undefined && refusal === undefined && (
          <ErrorNotice title={say("account.not_changed")} message={change.error.message} />
        )}
        <div>
          <button type="submit" class="button primary" disabled={change.busy}>
            {say("account.choose_pin")}
          </button>
        </div>
      </form>
      {chosen && (
        <Notice tone="good" title={say("account.changed")}>
          <p>{say("account.pin_chosen")}</p>
        </Notice>
      )}
    </Card>
  );
}
