import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Session } from "../../api/types";
import { useChange } from "../../api/use_change";
import { say } from "../../base/words";
import { ErrorNotice } from "../../widgets/basics";
import { TextField } from "../../widgets/form";

export const kMinPassword = 8;
const kMaxPassword = 1024;

// One's own password. Asks for the old one too, so that an unattended screen is not enough.
export function PasswordForm({
  client,
  login,
  onChanged,
}: {
  readonly client: Client;
  readonly login: string;
  readonly onChanged: (session: Session) => void;
}) {
  const [old, setOld] = useState("");
  const [fresh, setFresh] = useState("");
  const [again, setAgain] = useState("");
  const [checked, setChecked] = useState(false);
  const change = useChange();
  const problem = problemOf(old, fresh, again);
  const submit = async (event: Event) => {
    event.preventDefault();
    setChecked(true);
    if (problem !== undefined) return;
    const result = await change.run(() => client.changePassword(old, fresh));
    if (result?.ok !== true) return;
    setOld("");
    setFresh("");
    setAgain("");
    setChecked(false);
    onChanged(result.value);
  };
  const shown = checked ? problem : undefined;
  return (
    <form class="form narrow" onSubmit={(event) => void submit(event)}>
      <input
        class="hidden"
        type="text"
        name="username"
        autocomplete="username"
        value={login}
        readOnly
        tabIndex={-1}
        aria-hidden="true"
      />
      <TextField
        label={say("account.old_password")}
        secret
        autocomplete="current-password"
        required
        maxLength={kMaxPassword}
        value={old}
        onValue={setOld}
      />
      <TextField
        label={say("account.new_password")}
        secret
        autocomplete="new-password"
        required
        maxLength={kMaxPassword}
        value={fresh}
        onValue={setFresh}
        hint={say("account.password_hint", { least: kMinPassword })}
        problem={shown?.field === "new" ? shown.text : undefined}
      />
      <TextField
        label={say("account.new_password_again")}
        secret
        autocomplete="new-password"
        required
        maxLength={kMaxPassword}
        value={again}
        onValue={setAgain}
        problem={shown?.field === "again" ? shown.text : undefined}
      />
      {change.error !== undefined && <ErrorNotice title={say("account.not_changed")} message={change.error.message} />}
      <div>
        <button type="submit" class="button primary" disabled={change.busy}>
          {say("account.change_password")}
        </button>
      </div>
    </form>
  );
}

export function problemOf(
  old: string,
  fresh: string,
  again: string,
): { readonly field: "new" | "again"; readonly text: string } | undefined {
  const length = [...fresh].length;
  if (length < kMinPassword)
    return { field: "new", text: say("account.too_short", { least: kMinPassword, found: length }) };
  if (fresh === old) return { field: "new", text: say("account.same_password") };
  return fresh === again ? undefined : { field: "again", text: say("account.passwords_differ") };
}
