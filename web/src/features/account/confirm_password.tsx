import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { useChange } from "../../api/use_change";
import { say } from "../../base/words";
import { ErrorNotice } from "../../widgets/basics";
import { Dialog, FormButtons } from "../../widgets/dialog";
import { TextField } from "../../widgets/form";

interface Props {
  readonly client: Client;
  readonly onAnswer: (confirmed: boolean) => void;
}

// Before what is not to be done by whoever finds a page left open.
export function ConfirmPassword({ client, onAnswer }: Props) {
  const [password, setPassword] = useState("");
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() => client.post("/session/confirm", { body: { password } }));
    if (result?.ok === true) onAnswer(true);
  };
  return (
    <Dialog title={say("account.password_please")} onClose={() => onAnswer(false)}>
      <p>{say("account.sensitive")}</p>
      <form class="form" onSubmit={(event) => void submit(event)}>
        <TextField
          label={say("account.your_password")}
          secret
          autocomplete="current-password"
          required
          maxLength={1024}
          value={password}
          onValue={setPassword}
        />
        {change.error !== undefined && (
          <ErrorNotice
            title={say("account.not_confirmed")}
            message={change.error.field === "password" ? say("account.not_your_password") : change.error.message}
          />
        )}
        <FormButtons action={say("common.go_on")} busy={change.busy} onCancel={() => onAnswer(false)} />
      </form>
    </Dialog>
  );
}
