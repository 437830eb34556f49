import type { Client } from "../../api/client";
import type { Person, Session } from "../../api/types";
import { say } from "../../base/words";
import { PageTitle } from "../../widgets/basics";
import { PasswordForm } from "./password_form";

// All that somebody sees whose password was made up by the server.
export function ForcedPassword({
  client,
  person,
  onChanged,
  onSignOut,
}: {
  readonly client: Client;
  readonly person: Person;
  readonly onChanged: (session: Session) => void;
  readonly onSignOut: () => void;
}) {
  return (
    <main class="sign-in wide" id="content">
      <PageTitle document={say("account.choose_password")}>{say("account.choose_own")}</PageTitle>
      <p>{say("account.welcome", { name: person.display_name })}</p>
      <div class="card">
        <PasswordForm client={client} login={person.login} onChanged={onChanged} />
      </div>
      <p>
        <button type="button" class="button quiet" onClick={onSignOut}>
          {say("account.sign_out_instead")}
        </button>
      </p>
    </main>
  );
}
