import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { useChange } from "../../api/use_change";
import { say } from "../../base/words";
import { Card, ErrorNotice, Notice } from "../../widgets/basics";
import { TextField } from "../../widgets/form";

// The PIN with which instructors sign exams at a chair. It is never shown again.
export function PinCard({ client }: { readonly client: Client }) {
  const [pin, setPin] = useState("");
  const [chosen, setChosen] = useState(false);
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    setChosen(false);
    const result = await change.run(() => client.people.choosePin(pin));
    if (result?.ok !== true) return;
    setPin("");
    setChosen(true);
  };
  return (
    <Card title={say("account.pin")}>
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
          problem={change.error?.field === "pin" ? say("account.pin_refused") : undefined}
        />
        {change.error !== undefined && change.error.field !== "pin" && (
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
