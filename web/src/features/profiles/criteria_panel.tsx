import { wordedTitle } from "../../api/builtin_words";
import type { ProfileCriterion } from "../../api/types";
import { formatQuantity } from "../../base/format";
import { say } from "../../base/words";
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
          <LimitBars
            label={say("criteria.use")}
            items={bars.map((item) => ({
              title: wordedTitle(item.title),
              share: item.at_least ? item.limit / item.value : item.value / item.limit,
              ok: item.met,
            }))}
          />
          <p class="hint">{say("criteria.line")}</p>
        </div>
      )}
      <DataTable
        label={say("document_place.criteria")}
        items={criteria}
        rowKey={(item) => item.name}
        dense
        columns={[
          {
            title: say("common.criterion"),
            cell: (item) => (
              <>
                {wordedTitle(item.title)}
                <span class="sub">{item.formula}</span>
              </>
            ),
          },
          { title: say("criteria.figure"), number: true, cell: (item) => formatQuantity(item.value, item.unit) },
          { title: say("criteria.limit"), number: true, cell: (item) => limitText(item) },
          {
            title: say("criteria.result"),
            cell: (item) =>
              item.met ? (
                <Badge tone="good">{say("criteria.met")}</Badge>
              ) : (
                <Badge tone="bad">{say("criteria.not_met")}</Badge>
              ),
          },
        ]}
      />
    </div>
  );
}

function limitText(item: ProfileCriterion): string {
  const limit = formatQuantity(item.limit, item.unit);
  return item.at_least ? say("criteria.at_least", { limit }) : say("criteria.at_most", { limit });
}
