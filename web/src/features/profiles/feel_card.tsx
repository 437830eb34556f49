import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { FeelTissue, Profile, ProfileFeel } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatNumber, formatQuantity } from "../../base/format";
import { say } from "../../base/words";
import { Card, Empty, ErrorNotice, Loading, Segmented } from "../../widgets/basics";
import { SelectField } from "../../widgets/form";
import { type Column, DataTable } from "../../widgets/table";
import {
  bySpeed,
  cellAt,
  comparable,
  type Difference,
  differences,
  dampingText,
  feltText,
  figuresText,
  kMotions,
  kTones,
  type Motion,
  percent,
  referenceText,
  speedsOf,
  thresholdOf,
  tissueName,
  type Verdict,
} from "./feel";

const kIcons = { good: "✓", warning: "!", bad: "✕", neutral: "•" } as const;

// What a hand can feel on this device: tissue by speed, and what another device makes of it.
export function FeelCard({ client, profile }: { readonly client: Client; readonly profile: Profile }) {
  const { loaded, reload } = useRequest(`${profile.name} ${profile.version}`, (signal) =>
    client.profiles.feel(profile.name, signal),
  );
  return (
    <Card title={say("feel.title")} className="feel">
      {loaded.state === "loading" && <Loading what={say("loading.feel")} />}
      {loaded.state === "failed" && (
        <ErrorNotice title={say("feel.failed")} message={loaded.error.message} onRetry={reload} />
      )}
      {loaded.state === "ready" &&
        (loaded.value.has_motors ? (
          <Feel client={client} feel={loaded.value} />
        ) : (
          <Empty>{say("feel.no_motors")}</Empty>
        ))}
    </Card>
  );
}

function Feel({ client, feel }: { readonly client: Client; readonly feel: ProfileFeel }) {
  const [motion, setMotion] = useState<Motion>("strokes");
  const seen = new Set(feel.cells.filter((cell) => cell.motion === motion).map((cell) => cell.verdict));
  return (
    <>
      <p>{introduction(feel)}</p>
      <ul class="hint feel-sources">
        {feel.thresholds.map((threshold) => (
          <li key={threshold.name}>{thresholdText(threshold)}</li>
        ))}
      </ul>
      <Segmented
        legend={say("feel.motion_of_hand")}
        name="feel-motion"
        choices={kMotions.map((each) => ({ value: each, title: say(`feel_motion.${each}`) }))}
        value={motion}
        onChange={setMotion}
      />
      <FeelGrid feel={feel} motion={motion} />
      <dl class="feel-legend">
        {(Object.keys(kTones) as Verdict[])
          .filter((verdict) => seen.has(verdict))
          .map((verdict) => (
            <div key={verdict}>
              <dt>
                <Chip verdict={verdict} />
              </dt>
              <dd>{say(`feel_meaning.${verdict}`)}</dd>
            </div>
          ))}
      </dl>
      <details>
        <summary>{say("feel.how")}</summary>
        {method(feel, motion).map((sentence) => (
          <p key={sentence} class="hint">
            {sentence}
          </p>
        ))}
      </details>
      <Comparison client={client} feel={feel} />
    </>
  );
}

function FeelGrid({ feel, motion }: { readonly feel: ProfileFeel; readonly motion: Motion }) {
  const rows = feel.tissues.map((tissue, index) => ({ tissue, index }));
  const columns: Column<(typeof rows)[number]>[] = [
    {
      title: say("feel.tissue"),
      cell: ({ tissue }) => (
        <>
          {tissueName(tissue)}
          <span class="sub">{dampingText(tissue)}</span>
        </>
      ),
    },
    ...speedsOf(feel).map(
      (speed): Column<(typeof rows)[number]> => ({
        title: formatQuantity(speed, "mm/s"),
        cell: ({ index }) => <FeelCellText feel={feel} tissue={index} speed={speed} motion={motion} />,
      }),
    ),
  ];
  return (
    <DataTable
      label={motion === "strokes" ? say("feel.grid_strokes") : say("feel.grid_steady")}
      items={rows}
      columns={columns}
      dense
    />
  );
}

function FeelCellText({
  feel,
  tissue,
  speed,
  motion,
}: {
  readonly feel: ProfileFeel;
  readonly tissue: number;
  readonly speed: number;
  readonly motion: Motion;
}) {
  const cell = cellAt(feel, tissue, speed, motion);
  if (cell === undefined) return <>–</>;
  return (
    <div class={`feel-cell ${kTones[cell.verdict]}`}>
      <VerdictName verdict={cell.verdict} />
      <span class="feel-figures">{figuresText(cell)}</span>
      {cell.verdict !== "beyond_force" && <span class="feel-figures">{referenceText(cell)}</span>}
    </div>
  );
}

function VerdictName({ verdict }: { readonly verdict: Verdict }) {
  return (
    <span class="feel-verdict">
      <span aria-hidden="true">{kIcons[kTones[verdict]]} </span>
      {say(`feel_verdict.${verdict}`)}
    </span>
  );
}

function Chip({ verdict }: { readonly verdict: Verdict }) {
  return (
    <span class={`feel-cell ${kTones[verdict]}`}>
      <VerdictName verdict={verdict} />
    </span>
  );
}

// Fairness: the same exercise on two devices.
function Comparison({ client, feel }: { readonly client: Client; readonly feel: ProfileFeel }) {
  const { loaded } = useRequest("profiles", (signal) => client.profiles.all(signal));
  const [chosen, setChosen] = useState<string>();
  const others = loaded.state === "ready" ? loaded.value.filter((profile) => profile.name !== feel.name) : [];
  const name = chosen ?? others[0]?.name;
  const other = useRequest(name, (signal) => client.profiles.feel(name ?? "", signal));
  if (loaded.state === "failed")
    return <ErrorNotice title={say("feel.others_failed")} message={loaded.error.message} />;
  if (name === undefined) return null;
  return (
    <section class="stack" aria-label={say("feel.compared")}>
      <h3>{say("feel.fair")}</h3>
      <div class="form narrow">
        <SelectField
          label={say("feel.compare_with")}
          value={name}
          onValue={setChosen}
          options={others.map((profile) => ({ value: profile.name, title: profile.title }))}
        />
      </div>
      {other.loaded.state === "loading" && <Loading what={say("loading.other_device")} />}
      {other.loaded.state === "failed" && (
        <ErrorNotice title={say("feel.other_failed")} message={other.loaded.error.message} onRetry={other.reload} />
      )}
      {other.loaded.state === "ready" && <Differences mine={feel} other={other.loaded.value} />}
    </section>
  );
}

function Differences({ mine, other }: { readonly mine: ProfileFeel; readonly other: ProfileFeel }) {
  if (!other.has_motors) return <Empty>{say("feel.other_no_motors", { device: other.title })}</Empty>;
  const found = differences(mine, other);
  const all = comparable(mine, other);
  const rows = byTissue(found);
  return (
    <>
      <p>
        {found.length === 0
          ? say("feel.same", { count: all })
          : say("feel.different", {
              found: formatNumber(found.length, 0),
              count: all,
              viscosity: percent(thresholdOf(mine, "viscosity")),
              force: percent(thresholdOf(mine, "force")),
            })}
      </p>
      {rows.length > 0 && (
        <DataTable
          label={say("feel.where_different", { device: mine.title, other: other.title })}
          items={rows}
          dense
          columns={[
            { title: say("feel.tissue"), cell: (row) => tissueName(row.tissue) },
            { title: say("feel.motion"), cell: (row) => say(`feel_motion.${row.motion}`) },
            {
              title: say("feel.here"),
              cell: (row) => bySpeed(row.cells.map((item) => ({ speed: item.speed, text: feltText(item.mine) }))),
            },
            {
              title: say("feel.there"),
              cell: (row) => bySpeed(row.cells.map((item) => ({ speed: item.speed, text: feltText(item.other) }))),
            },
          ]}
        />
      )}
      {rows.length > 0 && <p class="hint">{say("feel.shares")}</p>}
    </>
  );
}

interface TissueDifference {
  readonly tissue: FeelTissue;
  readonly motion: Motion;
  readonly cells: readonly Difference[];
}

function byTissue(found: readonly Difference[]): TissueDifference[] {
  const rows = new Map<string, Difference[]>();
  for (const item of found) {
    const key = `${item.mine.tissue} ${item.motion}`;
    rows.set(key, [...(rows.get(key) ?? []), item]);
  }
  return [...rows.values()].map((cells) => ({ tissue: cells[0]!.tissue, motion: cells[0]!.motion, cells }));
}

function introduction(feel: ProfileFeel): string {
  const told = {
    force: percent(thresholdOf(feel, "force")),
    viscosity: percent(thresholdOf(feel, "viscosity")),
    delay: milliseconds(thresholdOf(feel, "delay")),
    coupling: couplingText(feel),
    ticks: feel.delay_ticks,
  };
  return feel.delay_measured || feel.delay_ticks === 0
    ? say("feel.introduction", told)
    : say("feel.introduction_not_measured", told);
}

function thresholdText({ name, value, unit, source }: ProfileFeel["thresholds"][number]): string {
  return say(`feel_threshold.${name}`, { value: unit === "s" ? milliseconds(value) : percent(value), source });
}

// One sentence or two each.
function method(feel: ProfileFeel, motion: Motion): string[] {
  const told = { coupling: couplingText(feel), ticks: feel.delay_ticks };
  return [
    feel.delay_measured ? say("feel.simulated_measured", told) : say("feel.simulated_not_measured", told),
    motion === "strokes" ? say("feel.figures_strokes") : say("feel.figures_steady"),
    say("feel.reference"),
    feel.tissues_of_scenes ? say("feel.tissues_scenes") : say("feel.tissues_built_in"),
    ...(feel.tissues_left_out > 0 ? [say("feel.left_out", { count: feel.tissues_left_out })] : []),
  ];
}

function couplingText(feel: ProfileFeel): string {
  return formatNumber(feel.coupling_mn_per_mm / 1000, 2);
}

function milliseconds(seconds: number): string {
  return formatQuantity(1000 * seconds, "ms");
}
