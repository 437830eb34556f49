import { useEffect, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Session } from "../../api/types";
import { useChange } from "../../api/use_change";
import { say } from "../../base/words";
import { ErrorNotice } from "../../widgets/basics";
import { BrandMark } from "../../widgets/brand";
import { TextField } from "../../widgets/form";

interface Props {
  readonly client: Client;
  readonly token: string; // of the link that the server printed
  readonly onSignedIn: (session: Session) => void;
}

const kMinPassword = 8;
const kFields = ["login", "display_name", "password"];

// The first account of a new server, made by a person who can read its output.
export function FirstAdmin({ client, token, onSignedIn }: Props) {
  const [login, setLogin] = useState("");
  const [name, setName] = useState("");
  const [password, setPassword] = useState("");
  const change = useChange();
  useEffect(() => {
    document.title = say("page_sign_in.first_document");
  }, []);
  const submit = async (event: Event) => {
    event.preventDefault();
    const made = await change.run(async () => {
      const result = await client.post("/first-admin", {
        body: { token, login: login.trim(), display_name: name.trim(), password },
        signingIn: true,
      });
      return result.ok ? client.signIn(login.trim(), password) : result;
    });
    if (made?.ok === true) onSignedIn(made.value);
  };
  const problemOf = (field: string) => (change.error?.field === field ? change.error.message : undefined);
  return (
    <main class="sign-in" id="content">
      <div class="sign-in-brand">
        <BrandMark />
        <span>Enamel</span>
      </div>
      <h1>{say("page_sign_in.first_admin")}</h1>
      <p>{say("page_sign_in.first_text")}</p>
      <form class="form" onSubmit={(event) => void submit(event)}>
        <TextField
          label={say("account.name")}
          value={name}
          onValue={setName}
          autocomplete="name"
          required
          maxLength={200}
          problem={problemOf("display_name")}
        />
        <TextField
          label={say("account.login")}
          hint={say("account.login_hint")}
          value={login}
          onValue={setLogin}
          autocomplete="username"
          required
          maxLength={64}
          problem={problemOf("login")}
        />
        <TextField
          label={say("account.password")}
          secret
          hint={say("account.password_hint", { least: kMinPassword })}
          value={password}
          onValue={setPassword}
          autocomplete="new-password"
          required
          minLength={kMinPassword}
          maxLength={1024}
          problem={problemOf("password")}
        />
        {change.error !== undefined && !kFields.includes(change.error.field) && (
          <ErrorNotice title={say("page_sign_in.not_made")} message={change.error.message} />
        )}
        <div>
          <button type="submit" class="button primary" disabled={change.busy}>
            {say("page_sign_in.make_account")}
          </button>
        </div>
      </form>
    </main>
  );
}
