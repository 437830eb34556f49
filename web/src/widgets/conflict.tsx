import { Notice } from "./basics";
import { DataTable } from "./table";

export interface Difference {
  readonly title: string;
  readonly theirs: string;
  readonly mine: string;
}

// Somebody else saved first: what they wrote beside what is about to be saved, and the two ways on.
export function Conflict({ differences, busy, onTakeTheirs, onKeepMine }:
    { readonly differences: readonly Difference[]; readonly busy: boolean; readonly onTakeTheirs: () => void; readonly onKeepMine: () => void }) {
  return (
    <Notice tone="warning" title="Somebody changed it meanwhile">
      <p>Nothing of yours was saved yet. Compare, then choose.</p>
      {differences.length === 0 ? <p>They saved the same as you wrote.</p> : (
        <DataTable label="What differs" items={differences} dense columns={[
          { title: "Field", cell: (item) => item.title },
          { title: "Saved by somebody else", cell: (item) => item.theirs === "" ? "–" : item.theirs },
          { title: "Written by you", cell: (item) => item.mine === "" ? "–" : item.mine },
        ]} />
      )}
      <div class="button-row">
        <button type="button" class="button" onClick={onTakeTheirs}>Take the newer values</button>
        <button type="button" class="button" disabled={busy} onClick={onKeepMine}>Save mine instead</button>
      </div>
    </Notice>
  );
}
