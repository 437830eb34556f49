import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { useChange } from "../../api/use_change";
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
    const result = await change.run(() => client.confirmPassword(password));
    if (result?.ok === true) onAnswer(true);
  };
  return (
    <Dialog title="Your password, please" onClose={() => onAnswer(false)}>
      <p>This change is a sensitive one. Give your own password again to go on.</p>
      <form class="form" onSubmit={(event) => void submit(event)}>
        <TextField label="Your password" secret autocomplete="current-password" required maxLength={1024} value={password} onValue={setPassword} />
        {change.error !== undefined && (
          <ErrorNotice title="Not confirmed" message={change.error.code === "unauthenticated" ? "This is not your password. Try again." : change.error.message} />
        )}
        <FormButtons action="Go on" disabled={change.busy} onCancel={() => onAnswer(false)} />
      </form>
    </Dialog>
  );
}
