import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { FeelTissue, Profile, ProfileFeel } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatNumber, plural } from "../../base/format";
import { Card, Empty, ErrorNotice, Loading, Segmented } from "../../widgets/basics";
import { SelectField } from "../../widgets/form";
import { type Column, DataTable } from "../../widgets/table";
import {
  bySpeed, cellAt, comparable, type Difference, differences, dampingText, feltText, figuresText, kMotions, kVerdicts, type Motion, percent, referenceText, speedsOf, thresholdOf, tissueName, type Verdict,
} from "./feel";

const kIcons = { good: "✓", warning: "!", bad: "✕", neutral: "•" } as const;

// What a hand can feel on this device: tissue by speed, and what another device makes of it.
export function FeelCard({ client, profile }: { readonly client: Client; readonly profile: Profile }) {
  const { loaded, reload } = useRequest(`${profile.name} ${profile.version}`, (signal) => client.profiles.feel(profile.name, signal));
  return (
    <Card title="What a hand can feel" className="feel">
      {loaded.state === "loading" && <Loading what="what a hand can feel" />}
      {loaded.state === "failed" && <ErrorNotice title="What a hand can feel could not be computed" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (loaded.value.has_motors ? <Feel client={client} feel={loaded.value} />
        : <Empty>This device has no motors: its force is shown on the screen, not felt.</Empty>)}
    </Card>
  );
}

function Feel({ client, feel }: { readonly client: Client; readonly feel: ProfileFeel }) {
  const [motion, setMotion] = useState<Motion>("strokes");
  const seen = new Set(feel.cells.filter((cell) => cell.motion === motion).map((cell) => cell.verdict));
  return (
    <>
      <p>{introduction(feel)}</p>
      <ul class="hint feel-sources">{feel.thresholds.map((threshold) => <li key={threshold.name}>{thresholdText(threshold)}</li>)}</ul>
      <Segmented legend="Motion of the hand" name="feel-motion" choices={kMotions} value={motion} onChange={setMotion} />
      <FeelGrid feel={feel} motion={motion} />
      <dl class="feel-legend">
        {(Object.keys(kVerdicts) as Verdict[]).filter((verdict) => seen.has(verdict)).map((verdict) => (
          <div key={verdict}><dt><Chip verdict={verdict} /></dt><dd>{kVerdicts[verdict].meaning}</dd></div>
        ))}
      </dl>
      <details>
        <summary>How this is computed</summary>
        <p class="hint">{method(feel, motion)}</p>
      </details>
      <Comparison client={client} feel={feel} />
    </>
  );
}

function FeelGrid({ feel, motion }: { readonly feel: ProfileFeel; readonly motion: Motion }) {
  const rows = feel.tissues.map((tissue, index) => ({ tissue, index }));
  const columns: Column<typeof rows[number]>[] = [
    { title: "Tissue", cell: ({ tissue }) => <>{tissueName(tissue)}<span class="sub">{dampingText(tissue)}</span></> },
    ...speedsOf(feel).map((speed): Column<typeof rows[number]> => ({ title: `${formatNumber(speed, 2)} mm/s`, cell: ({ index }) => <FeelCellText feel={feel} tissue={index} speed={speed} motion={motion} /> })),
  ];
  return <DataTable label={`What a hand can feel of each tissue, ${motion === "strokes" ? "strokes to and fro" : "a steady cut"}, by mean speed`} items={rows} columns={columns} dense />;
}

function FeelCellText({ feel, tissue, speed, motion }: { readonly feel: ProfileFeel; readonly tissue: number; readonly speed: number; readonly motion: Motion }) {
  const cell = cellAt(feel, tissue, speed, motion);
  if (cell === undefined) return <>–</>;
  return (
    <div class={`feel-cell ${kVerdicts[cell.verdict].tone}`}>
      <VerdictName verdict={cell.verdict} />
      <span class="feel-figures">{figuresText(cell)}</span>
      {cell.verdict !== "beyond_force" && <span class="feel-figures">{referenceText(cell)}</span>}
    </div>
  );
}

function VerdictName({ verdict }: { readonly verdict: Verdict }) {
  return <span class="feel-verdict"><span aria-hidden="true">{kIcons[kVerdicts[verdict].tone]} </span>{kVerdicts[verdict].title}</span>;
}

function Chip({ verdict }: { readonly verdict: Verdict }) {
  return <span class={`feel-cell ${kVerdicts[verdict].tone}`}><VerdictName verdict={verdict} /></span>;
}

// Fairness: the same exercise on two devices.
function Comparison({ client, feel }: { readonly client: Client; readonly feel: ProfileFeel }) {
  const { loaded } = useRequest("profiles", (signal) => client.profiles.all(signal));
  const [chosen, setChosen] = useState<string>();
  const others = loaded.state === "ready" ? loaded.value.filter((profile) => profile.name !== feel.name) : [];
  const name = chosen ?? others[0]?.name;
  const other = useRequest(name, (signal) => client.profiles.feel(name ?? "", signal));
  if (loaded.state === "failed") return <ErrorNotice title="The other devices could not be loaded" message={loaded.error.message} />;
  if (name === undefined) return null;
  return (
    <section class="stack" aria-label="Compared with another device">
      <h3>Is it fair beside another device?</h3>
      <div class="form narrow">
        <SelectField label="Compare with" value={name} onValue={setChosen} options={others.map((profile) => ({ value: profile.name, title: profile.title }))} />
      </div>
      {other.loaded.state === "loading" && <Loading what="the other device" />}
      {other.loaded.state === "failed" && <ErrorNotice title="The other device could not be computed" message={other.loaded.error.message} onRetry={other.reload} />}
      {other.loaded.state === "ready" && <Differences mine={feel} other={other.loaded.value} />}
    </section>
  );
}

function Differences({ mine, other }: { readonly mine: ProfileFeel; readonly other: ProfileFeel }) {
  if (!other.has_motors) return <Empty>{other.title} has no motors: nothing is felt on it.</Empty>;
  const found = differences(mine, other);
  const all = comparable(mine, other);
  const rows = byTissue(found);
  return (
    <>
      <p>
        {found.length === 0 ? `No difference that a hand can tell in ${plural(all, "case")}.`
          : `A hand can tell the two apart in ${found.length} of ${plural(all, "case")} (tissue, speed and motion): by more than ${percent(thresholdOf(mine, "viscosity"))} in the viscosity of strokes, or ${percent(thresholdOf(mine, "force"))} in the force of a steady cut. Attempts in these tissues do not compare.`}
      </p>
      {rows.length > 0 && (
        <DataTable label={`Where ${mine.title} and ${other.title} feel different`} items={rows} dense columns={[
          { title: "Tissue", cell: (row) => tissueName(row.tissue) },
          { title: "Motion", cell: (row) => kMotions.find((motion) => motion.value === row.motion)?.title ?? row.motion },
          { title: "Felt here", cell: (row) => bySpeed(row.cells.map((item) => ({ speed: item.speed, text: feltText(item.mine) }))) },
          { title: "Felt there", cell: (row) => bySpeed(row.cells.map((item) => ({ speed: item.speed, text: feltText(item.other) }))) },
        ]} />
      )}
      {rows.length > 0 && <p class="hint">Shares of what the tissue should feel like, at mean speeds in mm/s.</p>}
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
  return `A hand tells two forces apart from ${percent(thresholdOf(feel, "force"))}, two tissues by their viscosity from ${percent(thresholdOf(feel, "viscosity"))}, and feels a delay from ${formatNumber(1000 * thresholdOf(feel, "delay"), 0)} ms.`
    + ` Where this device stays below that, cutting feels as it is.`
    + ` Computed with a coupling of ${formatNumber(feel.coupling_mn_per_mm / 1000, 2)} N/mm and ${plural(feel.delay_ticks, "tick")} of delay${feel.delay_measured || feel.delay_ticks === 0 ? "" : ", which nobody measured"}.`;
}

function thresholdText({ name, value, unit, source }: ProfileFeel["thresholds"][number]): string {
  const title = { force: "Force", viscosity: "Viscosity", delay: "Delay of a damper" }[name];
  return `${title}, ${unit === "s" ? `${formatNumber(1000 * value, 0)} ms` : percent(value)}: ${source}.`;
}

function method(feel: ProfileFeel, motion: Motion): string {
  const delay = feel.delay_measured ? `${plural(feel.delay_ticks, "tick")} of delay, as measured`
    : `${plural(feel.delay_ticks, "tick")} of delay, which nobody measured: measuring it with enamel-station calibrate may allow a stiffer coupling and a better map`;
  const compared = motion === "strokes" ? "The figures are the RMS difference to B·v over strokes of a second, and the lag of the force."
    : "The figures are the mean difference to B·v once the force has built up, and how long that takes.";
  return `Simulated with the force law of exercises: a hand that moves freely, uniform tissue, Kc ${formatNumber(feel.coupling_mn_per_mm / 1000, 2)} N/mm, ${delay}. ${compared}`
    + " The reference is a force on the same device that knows the hand's speed and rises by at most Kc·v; from rest no passive law is faster, and where strokes turn ours may be, on energy it kept."
    + (feel.tissues_of_scenes ? " The tissues are those of the scenes on this server." : " No scene is on this server yet: the tissues are the built-in ones.")
    + (feel.tissues_left_out > 0 ? ` ${plural(feel.tissues_left_out, "softer tissue")} left out.` : "");
}
