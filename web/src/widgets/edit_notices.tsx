import type { Edit } from "../api/use_edit";
import { say } from "../base/words";
import { ErrorNotice, Notice } from "./basics";
import { Conflict, type Difference } from "./conflict";

// A field in the comparison after two people edited the same thing.
export interface Compared<T> {
  readonly title: string;
  readonly text: (value: T) => string;
}

// What came of saving: done, refused, or somebody else was faster. Fields that are named in
// `fields` show what is wrong with them themselves.
export function EditNotices<T>({
  edit,
  compared,
  fields,
}: {
  readonly edit: Edit<T>;
  readonly compared: readonly Compared<T>[];
  readonly fields: readonly string[];
}) {
  const { newer, error } = edit;
  return (
    <div aria-live="polite" class="edit-notices">
      {newer !== undefined && (
        <Conflict
          differences={differencesOf(compared, newer, edit.draft)}
          busy={edit.busy}
          onTakeTheirs={edit.takeTheirs}
          onKeepMine={() => void edit.keepMine()}
        />
      )}
      {error !== undefined && !fields.includes(error.field) && (
        <ErrorNotice title={say("common.not_saved")} message={error.message} />
      )}
      {edit.saved && (
        <Notice tone="good">
          <p>{say("common.saved")}</p>
        </Notice>
      )}
    </div>
  );
}

function differencesOf<T>(compared: readonly Compared<T>[], theirs: T, mine: T): Difference[] {
  return compared
    .map(({ title, text }) => ({ title, theirs: text(theirs), mine: text(mine) }))
    .filter((row) => row.theirs !== row.mine);
}
