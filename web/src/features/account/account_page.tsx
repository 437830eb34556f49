import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Person, Session } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { Badge, Card, ErrorNotice, Loading, Notice, PageTitle } from "../../widgets/basics";
import { SessionsTable } from "../../widgets/sessions_table";
import { PasswordForm } from "./password_form";

// Who one is here, one's password, and where one is signed in.
export function AccountPage({ client, person }: { readonly client: Client; readonly person: Person }) {
  const [changed, setChanged] = useState(false);
  return (
    <>
      <PageTitle document="My account">My account</PageTitle>
      <dl class="facts">
        <div><dt>Name</dt><dd>{person.display_name}</dd></div>
        <div><dt>Login</dt><dd><code>{person.login}</code></dd></div>
        <div><dt>Role</dt><dd>{person.role}</dd></div>
      </dl>
      <div class="columns">
        <Card title="Password">
          <PasswordForm client={client} login={person.login} onChanged={() => setChanged(true)} />
          {changed && <Notice tone="good" title="Changed"><p>Use the new password from now on. Elsewhere you are signed out.</p></Notice>}
        </Card>
        <OwnSessions client={client} />
      </div>
    </>
  );
}

function OwnSessions({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("sessions", (signal) => client.people.ownSessions(signal));
  return (
    <Card title="Where you are signed in">
      {loaded.state === "loading" && <Loading what="your sessions" />}
      {loaded.state === "failed" && <ErrorNotice title="Your sessions could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (
        <SessionsTable sessions={loaded.value} label="Your sessions"
                       onEnd={async (id) => {
                         const result = await client.people.endSession(id);
                         if (!result.ok) return result.error.message;
                         reload();
                         return undefined;
                       }} />
      )}
      <p class="hint">End a session that you do not know, then change your password. <Badge tone="neutral">This one</Badge> is where you are now.</p>
    </Card>
  );
}

// All that somebody sees whose password was made up by the server.
export function ForcedPassword({ client, person, onChanged, onSignOut }:
    { readonly client: Client; readonly person: Person; readonly onChanged: (session: Session) => void; readonly onSignOut: () => void }) {
  return (
    <main class="sign-in wide" id="content">
      <PageTitle document="Choose a password">Choose a password of your own</PageTitle>
      <p>Welcome, {person.display_name}. The password you were given is good for this one sign-in; somebody else has seen it.</p>
      <div class="card"><PasswordForm client={client} login={person.login} onChanged={onChanged} /></div>
      <p><button type="button" class="button quiet" onClick={onSignOut}>Sign out instead</button></p>
    </main>
  );
}
