import { useState } from "preact/hooks";
import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { reported } from "../../api/http";
import type { Profile, ProfileJudgement } from "../../api/types";
import { placedMessage } from "../../api/placed";
import { useChange } from "../../api/use_change";
import { usePages } from "../../api/use_pages";
import { say } from "../../base/words";
import { Card, ErrorNotice, Notice, PageTitle } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
import { FileField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { DataTable } from "../../widgets/table";
import { CriteriaPanel } from "./criteria_panel";

const kPageSize = 100;

// The haptic devices the school has, and what each may be asked for.
export function ProfilesPage({ client, admin }: { readonly client: Client; readonly admin: boolean }) {
  const pages = usePages("profiles", (cursor, signal) =>
    client.page("/profiles", { cursor, limit: kPageSize, signal }),
  );
  return (
    <>
      <PageTitle document={say("profiles.title")}>{say("profiles.title")}</PageTitle>
      <PagedList pages={pages} list="profiles" empty={say("profiles.none")}>
        {(profiles) => (
          <Card className="flush">
            <DataTable
              label={say("profiles.title")}
              items={profiles}
              rowKey={(profile) => profile.name}
              columns={[
                {
                  title: say("common.device"),
                  cell: (profile: Profile) => <a href={`/profiles/${profile.name}`}>{wordedTitle(profile.title)}</a>,
                },
                { title: say("document_place.name"), cell: (profile: Profile) => <code>{profile.name}</code> },
                { title: say("version.one"), number: true, cell: (profile: Profile) => profile.version },
                {
                  title: say("profile.numbers"),
                  cell: (profile: Profile) => say("profiles.numbers", { count: profile.numbers.length }),
                },
              ]}
            />
          </Card>
        )}
      </PagedList>
      {admin && <UploadProfile client={client} onDone={pages.reload} />}
    </>
  );
}

function UploadProfile({ client, onDone }: { readonly client: Client; readonly onDone: () => void }) {
  const [file, setFile] = useState<File>();
  const [stored, setStored] = useState<ProfileJudgement>();
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    if (file === undefined) return;
    const text = await file.text();
    const result = await change.run(() => reported(client.post("/profiles", { body: text }), "criteria"));
    setStored(result?.ok === true ? result.value : undefined);
    if (result?.ok === true && result.value.stored) onDone();
  };
  return (
    <Card title={say("profiles.add")}>
      <form class="form narrow" onSubmit={(event) => void submit(event)}>
        <FileField
          label={say("profiles.file")}
          accept=".json,application/json"
          onFile={setFile}
          hint={say("profiles.file_hint")}
        />
        <div>
          <Button busy={change.busy} blocked={needed({ [say("profiles.file")]: file })}>
            {say("profiles.check_save")}
          </Button>
        </div>
      </form>
      {change.error !== undefined && (
        <ErrorNotice title={say("common.not_saved")} message={placedMessage(change.error)} />
      )}
      {stored !== undefined && (
        <>
          {stored.stored ? (
            <Notice
              tone="good"
              title={say("profiles.saved_as", { version: String(stored.version), name: stored.name })}
            />
          ) : (
            <Notice tone="bad" title={say("common.not_saved")}>
              <p>{say("profiles.not_stable")}</p>
            </Notice>
          )}
          <CriteriaPanel criteria={stored.criteria} />
        </>
      )}
    </Card>
  );
}
