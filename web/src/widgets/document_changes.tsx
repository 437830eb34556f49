import { type Change, changesBetween, type Json } from "../base/document";
import { say } from "../base/words";
import { shownValue } from "./document_fields";
import { DataTable } from "./table";

// What differs between two documents, by place. `titleOf`: what a place is called.
export function DocumentChanges({
  before,
  after,
  beforeTitle,
  afterTitle,
  titleOf,
  label,
}: {
  readonly before: Json;
  readonly after: Json;
  readonly beforeTitle: string;
  readonly afterTitle: string;
  readonly titleOf: (change: Change) => string;
  readonly label: string;
}) {
  const changes = changesBetween(before, after);
  if (changes.length === 0) return <p class="hint">{say("document.same")}</p>;
  return (
    <DataTable
      label={label}
      items={changes}
      rowKey={(change) => change.path.join(".") + (change.after === undefined ? " gone" : "")}
      dense
      columns={[
        { title: say("document.place"), cell: titleOf },
        { title: beforeTitle, cell: (change) => shownValue(change.before) },
        { title: afterTitle, cell: (change) => shownValue(change.after) },
      ]}
    />
  );
}
