import type { ProfileCriterion } from "../../api/types";
import { formatQuantity } from "../../base/format";
import { Badge } from "../../widgets/basics";
import { LimitBars } from "../../widgets/limit_bars";
import { DataTable } from "../../widgets/table";

// Whether a device is stable with its numbers, criterion by criterion: as bars and as a table.
export function CriteriaPanel({ criteria }: { readonly criteria: readonly ProfileCriterion[] }) {
  const bars = criteria.filter((item) => item.limit > 0 && item.value > 0);
  return (
    <div class="columns">
      {bars.length > 0 && (
        <div class="stack">
          <LimitBars label="Use of the limits" items={bars.map((item) => ({ title: item.title, share: item.at_least ? item.limit / item.value : item.value / item.limit, ok: item.met }))} />
          <p class="hint">The line is the limit.</p>
        </div>
      )}
      <DataTable label="Criteria" items={criteria} rowKey={(item) => item.name} dense columns={[
        { title: "Criterion", cell: (item) => <>{item.title}<span class="sub">{item.formula}</span></> },
        { title: "Figure", number: true, cell: (item) => formatQuantity(item.value, item.unit) },
        { title: "Limit", number: true, cell: (item) => <>{item.at_least ? "at least" : "at most"} {formatQuantity(item.limit, item.unit)}</> },
        { title: "Result", cell: (item) => item.met ? <Badge tone="good">Met</Badge> : <Badge tone="bad">Not met</Badge> },
      ]} />
    </div>
  );
}
