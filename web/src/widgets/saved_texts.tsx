import { useState } from "preact/hooks";
import { foundIn, type SavedTexts } from "../api/saved_texts";
import type { SavedText } from "../api/types";
import { say } from "../base/words";
import { Brief, ErrorNotice } from "./basics";
import { Button, needed } from "./button";
import { LongTextField, TextField } from "./form";

const kMaxText = 4000;
const kFewTexts = 8; // more than fit beside a remark at a glance: there is a field to look through them

// Saves what is being written; nothing where it is empty or saved.
export function SaveText({ saved, text }: { readonly saved: SavedTexts; readonly text: string }) {
  const own = text.trim();
  if (own === "" || saved.texts.some((each) => each.mine && each.text === own)) return null;
  return (
    <button type="button" class="button" disabled={saved.busy} onClick={() => void saved.save(own)}>
      {say("texts.save")}
    </button>
  );
}

// The list to choose from. `onUse`: the text goes into the remark that is being written.
export function SavedTextList({
  saved,
  onUse,
}: {
  readonly saved: SavedTexts;
  readonly onUse: (text: string) => void;
}) {
  const { texts, busy, error, made } = saved;
  const [sought, setSought] = useState("");
  const [edited, setEdited] = useState<string>();
  const found = foundIn(texts, sought);
  return (
    <>
      {error !== undefined && <ErrorNotice title={say("common.not_saved")} message={error.message} />}
      {made !== undefined && (
        <p class="hint" role="status">
          {say(`texts.${made.what}`, { text: made.text })}{" "}
          <button type="button" class="button small" disabled={busy} onClick={() => void made.undo()}>
            {say("edit.undo")}
          </button>
        </p>
      )}
      {texts.length > 0 && (
        <details class="saved-texts">
          <summary>{say("texts.title", { count: texts.length })}</summary>
          {texts.length > kFewTexts && <TextField label={say("texts.search")} value={sought} onValue={setSought} />}
          <ul>
            {found.map((row) => (
              <li key={row.id}>
                {edited === row.id ? (
                  <EditText saved={saved} row={row} onDone={() => setEdited(undefined)} />
                ) : (
                  <Row saved={saved} row={row} onUse={onUse} onEdit={() => setEdited(row.id)} />
                )}
              </li>
            ))}
          </ul>
          {found.length === 0 && <p class="hint">{say("texts.none_found")}</p>}
        </details>
      )}
    </>
  );
}

function Row({
  saved,
  row,
  onUse,
  onEdit,
}: {
  readonly saved: SavedTexts;
  readonly row: SavedText;
  readonly onUse: (text: string) => void;
  readonly onEdit: () => void;
}) {
  const { text, shared, mine } = row;
  const share = shared ? "unshare" : "share";
  const act = (key: "edit" | "remove" | "share" | "unshare", onClick: () => void) => (
    <button type="button" class="button small quiet" disabled={saved.busy} onClick={onClick}>
      <Brief shown={say(`texts.${key}`)} full={say(`texts.${key}_which`, { text })} />
    </button>
  );
  return (
    <>
      <button type="button" class="button small quiet saved-text" onClick={() => onUse(text)}>
        {text}
      </button>
      <span class="saved-text-actions">
        {!mine && <span class="hint">{say("texts.by", { name: row.owner.display_name })}</span>}
        {row.may_change && (mine || shared) && act(share, () => void saved.replace(row, { text, shared: !shared }))}
        {mine && act("edit", onEdit)}
        {mine && act("remove", () => void saved.remove(row))}
      </span>
    </>
  );
}

function EditText({
  saved,
  row,
  onDone,
}: {
  readonly saved: SavedTexts;
  readonly row: SavedText;
  readonly onDone: () => void;
}) {
  const [text, setText] = useState(row.text);
  const save = async () => {
    if (await saved.replace(row, { text, shared: row.shared })) onDone();
  };
  return (
    <div class="form">
      <LongTextField label={say("texts.one")} value={text} onValue={setText} required maxLength={kMaxText} rows={2} />
      <div class="button-row">
        <Button
          kind="primary small"
          busy={saved.busy}
          blocked={needed({ [say("texts.one")]: text.trim() })}
          onClick={() => void save()}
        >
          {say("common.save")}
        </Button>
        <button type="button" class="button small" onClick={onDone}>
          {say("common.cancel")}
        </button>
      </div>
    </div>
  );
}
