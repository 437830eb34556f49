import type { ComponentChildren } from "preact";
import { formatLimit, formatPoints } from "../../base/format";
import { say } from "../../base/words";
import { DataTable } from "../../widgets/table";
import { aboutPoints, kChosen, type Price, priceTitle, sizesText } from "./price";

export const kLeewayMm = 0.1; // scoring::kLeeway_m: nobody pays for less

// What each part of the cut costs, and from which size on an examiner asks for a change or for new work.
export function PricesTable({ prices }: { readonly prices: readonly Price[] }) {
  const read = prices.filter(({ source }) => source !== kChosen && source !== "");
  return (
    <>
      <p class="hint">{say("price.once")}</p>
      <DataTable
        label={say("price.table")}
        items={prices}
        rowKey={({ of }) => of}
        dense
        columns={[
          { title: say("price.part"), cell: ({ of }) => priceTitle(of) },
          {
            title: say("price.costs"),
            cell: (price) => (
              <span>
                {say("price.about", { points: formatPoints(aboutPoints(price)) })}
                {linesOf(sizesAt(price))}
              </span>
            ),
          },
          {
            title: say("price.modify_from"),
            cell: (price) => linesOf(sizesText(price, price.modify_points)),
          },
          { title: say("price.redo_from"), cell: (price) => linesOf(sizesText(price, price.redo_points)) },
          { title: say("price.at_most"), number: true, cell: ({ most }) => formatPoints(most) },
        ]}
      />
      <p class="hint">{say("price.states")}</p>
      <p class="hint">{say("price.even_layer", { leeway: formatLimit(kLeewayMm, "mm") })}</p>
      <p class="hint">{say("price.not_done")}</p>
      <p class="hint">
        {[
          ...read.map(({ of, source }) => say("price.source_of", { part: priceTitle(of), source })),
          ...(read.length < prices.length ? [say(read.length === 0 ? "price.all_chosen" : "price.rest_chosen")] : []),
        ].join(" ")}
      </p>
    </>
  );
}

// As the rubric gives them, not where the curve is at exactly so many points.
function sizesAt({ over, left, unit }: Price): string[] {
  if (over !== null && over === left) return [say("price.at_either", { size: formatLimit(over, unit) })];
  if (over !== null && left !== null)
    return [
      say("price.at_over", { size: formatLimit(over, unit) }),
      say("price.at_left", { size: formatLimit(left, unit) }),
    ];
  return [say("price.at", { size: formatLimit(over ?? left ?? Number.NaN, unit) })];
}

function linesOf(lines: readonly string[]): ComponentChildren {
  if (lines.length === 0) return say("price.never");
  return (
    <span>
      {lines.map((line) => (
        <span key={line} class="price-line">
          {line}
        </span>
      ))}
    </span>
  );
}
