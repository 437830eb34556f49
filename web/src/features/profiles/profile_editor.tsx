import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { reported } from "../../api/http";
import { placeText } from "../../api/place_text";
import { placedMessage } from "../../api/placed";
import { useChange } from "../../api/use_change";
import { useCheck } from "../../api/use_check";
import { useRequest } from "../../api/use_request";
import type { Json } from "../../base/document";
import { say } from "../../base/words";
import { Card, ErrorNotice, Notice, PageTitle, Waits } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { type DocumentForm, DocumentNumber, DocumentText, stillWrong } from "../../widgets/document_fields";
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

// A device profile in a form: each number with its source, and whether the device would be stable
// with them.
export function ProfileEditorPage({ client, name, onOpen }: Props) {
  const { loaded, reload } = useRequest(`editor ${name}`, (signal) => client.get("/profiles/{name}", { name, signal }));
  if (loaded.state !== "ready")
    return (
      <Waits loaded={loaded} reload={reload} what={say("loading.profile")} failed={say("profile.failed")}>
        <PageTitle document={say("editor.document")}>{say("profile_editor.title")}</PageTitle>
      </Waits>
    );
  const { version, document } = loaded.value;
  const title = wordedTitle(loaded.value.title);
  return (
    <Editor
      key={version}
      client={client}
      name={name}
      title={title}
      version={version}
      read={document as unknown as Json}
      onOpen={onOpen}
    />
  );
}

function Editor({
  client,
  name,
  title,
  version,
  read,
  onOpen,
}: {
  readonly client: Client;
  readonly name: string;
  readonly title: string;
  readonly version: number;
  readonly read: Json;
  readonly onOpen: (path: string) => void;
}) {
  const edit = useDocument(`profile ${name}`, read);
  const text = JSON.stringify(edit.now);
  const check = useCheck(text, (asked, signal) =>
    reported(client.post("/profiles", { dry_run: true, body: asked, signal }), "criteria"),
  );
  const change = useChange();
  const refused = check.value?.acceptable === false;
  const form: DocumentForm = { edit, wrong: stillWrong(check, edit.now) };
  const save = async () => {
    const result = await change.run(() => reported(client.post("/profiles", { body: text }), "criteria"));
    if (result?.ok !== true || !result.value.acceptable) return;
    edit.forget();
    onOpen(`/profiles/${name}`);
  };
  const numbers = Object.entries(edit.now as { readonly [member: string]: Json }).filter(
    ([, value]) => value !== null && typeof value === "object" && "source" in value,
  );
  const state = check.busy
    ? say("editor.checking")
    : check.error !== undefined
      ? say("editor.not_right")
      : refused
        ? say("profile_editor.refused")
        : edit.dirty
          ? say("editor.right_not_saved")
          : say("editor.as_saved");
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href={`/profiles/${name}`}>{title}</a>
      </nav>
      <PageTitle document={say("editor.edit", { title })}>{say("editor.edit", { title })}</PageTitle>
      <EditBar edit={edit} state={state}>
        <Button
          busy={change.busy || check.busy}
          blocked={
            check.error !== undefined
              ? say("rubric.mend_first")
              : refused
                ? say("profile_editor.refused")
                : edit.dirty
                  ? undefined
                  : say("rubric.nothing_changed")
          }
          onClick={() => void save()}
        >
          {say("profile_editor.save", { version: String(version + 1) })}
        </Button>
      </EditBar>
      <div aria-live="polite" class="edit-notices">
        {form.wrong !== undefined && (
          <Notice tone="bad" title={say("editor.not_right")}>
            <p>{placedMessage(form.wrong, placeText(form.wrong.field))}</p>
          </Notice>
        )}
        {refused && (
          <Notice tone="bad" title={say("profile_editor.would_refuse")}>
            <p>{say("profile_editor.would_refuse_text")}</p>
          </Notice>
        )}
        {change.error !== undefined && <ErrorNotice title={say("common.not_saved")} message={change.error.message} />}
      </div>
      <div class="editor">
        <Card title={say("profile_editor.known")}>
          <div class="form">
            <DocumentText form={form} path={["title"]} label={say("editor.title_field")} maxLength={200} />
            {numbers.map(([member]) => (
              <div class="form-grid" key={member}>
                <DocumentNumber form={form} path={[member, "value"]} label={memberTitle(member)} />
                <DocumentText
                  form={form}
                  path={[member, "source"]}
                  label={say("profile_editor.source_of", { number: memberTitle(member) })}
                  maxLength={200}
                />
              </div>
            ))}
          </div>
        </Card>
        <div class="stack editor-side">
          <Card title={say("editor.changes_against", { title: say("version.number", { number: String(version) }) })}>
            <DocumentChanges
              label={say("profile_editor.changes_saved")}
              before={read}
              after={edit.now}
              beforeTitle={say("version.title_number", { number: String(version) })}
              afterTitle={say("editor.here")}
              titleOf={({ path }) => placeTitle(path)}
            />
          </Card>
          {check.value !== undefined && (
            <Card title={say("profile_editor.stable")}>
              <CriteriaPanel criteria={check.value.criteria} />
            </Card>
          )}
        </div>
      </div>
    </>
  );
}

function placeTitle(path: readonly (string | number)[]): string {
  if (path[0] === "title") return say("editor.title_field");
  const number = memberTitle(String(path[0]));
  return path[1] === "source" ? say("profile_editor.source", { number }) : number;
}
