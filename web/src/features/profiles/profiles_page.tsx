import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Profile, ProfileJudgement } from "../../api/types";
import { placedMessage } from "../../api/http";
import { useChange } from "../../api/use_change";
import { usePages } from "../../api/use_pages";
import { plural } from "../../base/format";
import { Card, ErrorNotice, Notice, PageTitle } from "../../widgets/basics";
import { FileField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { DataTable } from "../../widgets/table";
import { CriteriaPanel } from "./criteria_panel";

const kPageSize = 100;

// The haptic devices the school has, and what each may be asked for.
export function ProfilesPage({ client, admin }: { readonly client: Client; readonly admin: boolean }) {
  const pages = usePages("profiles", (cursor, signal) => client.profiles.list({ cursor, limit: kPageSize }, signal));
  return (
    <>
      <PageTitle document="Device profiles">Device profiles</PageTitle>
      <PagedList pages={pages} list="profiles" empty="There is no device profile yet.">
        {(profiles) => (
          <Card className="flush">
            <DataTable label="Device profiles" items={profiles} rowKey={(profile) => profile.name} columns={[
              { title: "Device", cell: (profile: Profile) => <a href={`/profiles/${profile.name}`}>{profile.title}</a> },
              { title: "Name", cell: (profile: Profile) => <code>{profile.name}</code> },
              { title: "Version", number: true, cell: (profile: Profile) => profile.version },
              { title: "Numbers", cell: (profile: Profile) => `${plural(profile.numbers.length, "number")}, each with its source` },
            ]} />
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
    const result = await change.run(() => client.profiles.upload(text));
    setStored(result?.ok === true ? result.value : undefined);
    if (result?.ok === true && result.value.stored) onDone();
  };
  return (
    <Card title="Add a profile, or a new version of one">
      <form class="form narrow" onSubmit={(event) => void submit(event)}>
        <FileField label="Profile document (JSON)" accept=".json,application/json" onFile={setFile}
                   hint="As enamel-station calibrate proposes it. Whether the device would be stable with these numbers is checked before anything is saved." />
        <div><button type="submit" class="button primary" disabled={change.busy || file === undefined}>Check and save</button></div>
      </form>
      {change.error !== undefined && (
        <ErrorNotice title="Not saved" message={placedMessage(change.error)} />
      )}
      {stored !== undefined && (
        <>
          {stored.stored ? <Notice tone="good" title={`Saved as version ${stored.version} of ${stored.name}`} />
            : <Notice tone="bad" title="Not saved"><p>A device with these numbers would not be stable: see what is not met.</p></Notice>}
          <CriteriaPanel criteria={stored.criteria} />
        </>
      )}
    </Card>
  );
}
