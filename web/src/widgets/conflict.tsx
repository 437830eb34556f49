import { say } from "../base/words";
import { Notice } from "./basics";
import { DataTable } from "./table";

export interface Difference {
  readonly title: string;
  readonly theirs: string;
  readonly mine: string;
}

// Somebody else saved first: their version beside this one, and the two ways to continue.
export function Conflict({
  differences,
  busy,
  onTakeTheirs,
  onKeepMine,
}: {
  readonly differences: readonly Difference[];
  readonly busy: boolean;
  readonly onTakeTheirs: () => void;
  readonly onKeepMine: () => void;
}) {
  return (
    <Notice tone="warning" title={say("conflict.title")}>
      <p>{say("conflict.compare")}</p>
      {differences.length === 0 ? (
        <p>{say("conflict.same")}</p>
      ) : (
        <DataTable
          label={say("conflict.differs")}
          items={differences}
          dense
          columns={[
            { title: say("common.field"), cell: (item) => item.title },
            { title: say("conflict.theirs"), cell: (item) => (item.theirs === "" ? "–" : item.theirs) },
            { title: say("conflict.mine"), cell: (item) => (item.mine === "" ? "–" : item.mine) },
          ]}
        />
      )}
      <div class="button-row">
        <button type="button" class="button" onClick={onTakeTheirs}>
          {say("conflict.take_theirs")}
        </button>
        <button type="button" class="button" disabled={busy} onClick={onKeepMine}>
          {say("conflict.keep_mine")}
        </button>
      </div>
    </Notice>
  );
}
