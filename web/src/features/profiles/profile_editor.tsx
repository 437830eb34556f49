import type { Client } from "../../api/client";
import { useChange } from "../../api/use_change";
import { useCheck } from "../../api/use_check";
import { useRequest } from "../../api/use_request";
import type { Json } from "../../base/document";
import { Card, ErrorNotice, Loading, Notice, PageTitle } from "../../widgets/basics";
import { type DocumentForm, DocumentNumber, DocumentText } from "../../widgets/document_fields";
import { DocumentChanges } from "../../widgets/document_changes";
import { EditBar } from "../../widgets/edit_bar";
import { useDocument } from "../../widgets/use_document";
import { CriteriaPanel } from "./criteria_panel";
import { memberTitle } from "./profile_text";

interface Props {
  readonly client: Client;
  readonly name: string;
  readonly onOpen: (path: string) => void;
}

// A device profile in a form: each number with its source, and whether the device would be stable with them.
export function ProfileEditorPage({ client, name, onOpen }: Props) {
  const { loaded, reload } = useRequest(`editor ${name}`, (signal) => client.profiles.get(name, signal));
  if (loaded.state === "loading") return <Loading what="the device profile" />;
  if (loaded.state === "failed") return <><PageTitle document="Edit">Edit a device profile</PageTitle><ErrorNotice title="The profile could not be loaded" message={loaded.error.message} onRetry={reload} /></>;
  const { title, version, document } = loaded.value;
  return <Editor key={version} client={client} name={name} title={title} version={version} read={document as unknown as Json} onOpen={onOpen} />;
}

function Editor({ client, name, title, version, read, onOpen }: { readonly client: Client; readonly name: string; readonly title: string; readonly version: number; readonly read: Json; readonly onOpen: (path: string) => void }) {
  const edit = useDocument(`profile ${name}`, read);
  const text = JSON.stringify(edit.now);
  const check = useCheck(text, (asked, signal) => client.profiles.check(asked, signal));
  const change = useChange();
  const refused = check.value?.acceptable === false;
  const form: DocumentForm = { edit, wrong: check.error };
  const save = async () => {
    const result = await change.run(() => client.profiles.upload(text));
    if (result?.ok !== true || !result.value.acceptable) return;
    edit.forget();
    onOpen(`/profiles/${name}`);
  };
  const numbers = Object.entries(edit.now as { readonly [member: string]: Json }).filter(([, value]) => value !== null && typeof value === "object" && "source" in value);
  const state = check.busy ? "Checking…" : check.error !== undefined ? "Not right yet" : refused ? "Would be refused" : edit.dirty ? "Right, not saved" : "As saved";
  return (
    <>
      <nav class="trail" aria-label="Where you are"><a href={`/profiles/${name}`}>{title}</a></nav>
      <PageTitle document={`Edit ${title}`}>{`Edit ${title}`}</PageTitle>
      <EditBar edit={edit} state={state}>
        <button type="button" class="button primary" disabled={change.busy || check.busy || check.error !== undefined || refused || !edit.dirty} onClick={() => void save()}>Save as version {version + 1}</button>
      </EditBar>
      <div aria-live="polite" class="edit-notices">
        {check.error !== undefined && <Notice tone="bad" title="Not right yet"><p>{check.error.field === "" ? "" : `${check.error.field}: `}{check.error.message}</p></Notice>}
        {refused && <Notice tone="bad" title="The server would refuse it"><p>A criterion below is not met. Change a number, or measure the device again.</p></Notice>}
        {change.error !== undefined && <ErrorNotice title="Not saved" message={change.error.message} />}
      </div>
      <div class="editor">
        <Card title="What is known of the device">
          <div class="form">
            <DocumentText form={form} path={["title"]} label="Title" maxLength={200} />
            {numbers.map(([member]) => (
              <div class="form-grid" key={member}>
                <DocumentNumber form={form} path={[member, "value"]} label={memberTitle(member)} />
                <DocumentText form={form} path={[member, "source"]} label={`Where this is from: ${memberTitle(member)}`} maxLength={200} />
              </div>
            ))}
          </div>
        </Card>
        <div class="stack editor-side">
          <Card title={`Changes against version ${version}`}>
            <DocumentChanges label="Changes against the version that is saved" before={read} after={edit.now} beforeTitle={`Version ${version}`} afterTitle="Here"
                             titleOf={({ path }) => path[0] === "title" ? "Title" : `${memberTitle(String(path[0]))}${path[1] === "source" ? ", source" : ""}`} />
          </Card>
          {check.value !== undefined && <Card title="Whether it is stable"><CriteriaPanel criteria={check.value.criteria} /></Card>}
        </div>
      </div>
    </>
  );
}
