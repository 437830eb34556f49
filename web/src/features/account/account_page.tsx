import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { failed } from "../../api/http";
import type { Person, Session } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { kLanguages } from "../../base/language";
import { say, sayWith } from "../../base/words";
import { Badge, Card, ErrorNotice, Notice, PageTitle, Waits } from "../../widgets/basics";
import { SelectField } from "../../widgets/form";
import { SessionsTable } from "../../widgets/sessions_table";
import { PasswordForm } from "./password_form";
import { PinCard } from "./pin_form";

// Who one is here, one's password, and where one is signed in.
interface Props {
  readonly client: Client;
  readonly person: Person;
  readonly language: Session["language"];
  readonly onLanguage: (language: Session["language"]) => Promise<string | undefined>; // the reason when it failed
}

export function AccountPage({ client, person, language, onLanguage }: Props) {
  const [changed, setChanged] = useState(false);
  return (
    <>
      <PageTitle document={say("account.title")}>{say("account.title")}</PageTitle>
      <dl class="facts">
        <div>
          <dt>{say("account.name")}</dt>
          <dd>{person.display_name}</dd>
        </div>
        <div>
          <dt>{say("account.login")}</dt>
          <dd>
            <code>{person.login}</code>
          </dd>
        </div>
        <div>
          <dt>{say("account.role")}</dt>
          <dd>{say(`role.${person.role}`)}</dd>
        </div>
      </dl>
      <div class="columns">
        <Card title={say("account.password")}>
          <PasswordForm client={client} login={person.login} onChanged={() => setChanged(true)} />
          {changed && (
            <Notice tone="good" title={say("account.changed")}>
              <p>{say("account.changed_text")}</p>
            </Notice>
          )}
        </Card>
        {person.role !== "student" && <PinCard client={client} />}
        <LanguageCard language={language} onLanguage={onLanguage} />
        <OwnSessions client={client} />
      </div>
    </>
  );
}

function LanguageCard({ language, onLanguage }: Pick<Props, "language" | "onLanguage">) {
  const [problem, setProblem] = useState<string>();
  const choose = async (choice: Session["language"]) => setProblem(await onLanguage(choice));
  return (
    <Card title={say("account.language")}>
      <SelectField<Session["language"]>
        label={say("account.page_language")}
        value={language}
        onValue={(choice) => void choose(choice)}
        options={[
          { value: "", title: say("account.language_browser") },
          ...kLanguages.map(({ code, name }) => ({ value: code, title: name })),
        ]}
      />
      {problem !== undefined && <ErrorNotice title={say("account.language_failed")} message={problem} />}
    </Card>
  );
}

function OwnSessions({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("sessions", (signal) => client.all("/sessions", { signal }));
  return (
    <Card title={say("account.sessions")}>
      <Waits
        loaded={loaded}
        reload={reload}
        what={say("loading.own_sessions")}
        failed={say("account.sessions_failed")}
      />
      {loaded.state === "ready" && (
        <SessionsTable
          sessions={loaded.value}
          label={say("account.your_sessions")}
          onEnd={(id) => failed(client.delete("/sessions/{id}", { id }), reload)}
        />
      )}
      <p class="hint">
        {sayWith("account.end_unknown", { this_one: <Badge tone="neutral">{say("sessions.this_one")}</Badge> })}
      </p>
    </Card>
  );
}
