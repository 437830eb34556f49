import type { Profile } from "../../api/types";
import { formatNumber, formatQuantity } from "../../base/format";
import { say } from "../../base/words";
import { Card, Empty } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import { couplingOf, kShares, kTissues, stiffestGrip } from "./feel";

// Up to which grip cutting feels right on this device, by tissue.
export function FeelCard({ profile }: { readonly profile: Profile }) {
  const coupling = couplingOf(profile);
  if (coupling === undefined)
    return (
      <Card title={say("feel.title")}>
        <Empty>{say("feel.no_motors")}</Empty>
      </Card>
    );
  return (
    <Card title={say("feel.title")}>
      <p>{say("feel.introduction", { coupling: formatNumber(coupling, 2) })}</p>
      <DataTable
        label={say("feel.title")}
        items={kTissues}
        rowKey={(tissue) => tissue.name}
        dense
        columns={[
          {
            title: say("feel.tissue"),
            cell: (tissue) => (
              <>
                {say(`tooth_tissue.${tissue.name}`)}
                <span class="sub">{say("feel.tissue_damping", { damping: formatNumber(tissue.damping, 1) })}</span>
              </>
            ),
          },
          ...kShares.map((share) => ({
            title: say("feel.within", { share: formatQuantity(100 * share, "%") }),
            number: true,
            cell: (tissue: (typeof kTissues)[number]) => gripText(stiffestGrip(coupling, tissue.damping, share)),
          })),
        ]}
      />
      <p class="hint">{say("feel.sources")}</p>
    </Card>
  );
}

function gripText(grip: number): string {
  if (grip === 0) return say("feel.never");
  return Number.isFinite(grip) ? formatQuantity(grip, "N/mm") : say("feel.any");
}
