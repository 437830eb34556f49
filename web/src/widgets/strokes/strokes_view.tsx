import { useMemo, useState } from "preact/hooks";
import type { StrokeCase, StrokeDevice, Strokes, StrokeTrack } from "../../api/strokes";
import { formatNumber } from "../../base/format";
import { say, sayWith } from "../../base/words";
import { Badge, Segmented, TableFrame } from "../basics";
import { TrackPlot } from "../track_plot";
import {
  caseSentence,
  caseText,
  drawn,
  figureText,
  figureTitle,
  joined,
  kIdealLine,
  kOracleLine,
  kWholeLine,
  lawLine,
  type TrackLine,
} from "./tracks";

// How cutting feels on a device: force against time beside the ideal, one row for each motion.
export function StrokesView({ strokes }: { readonly strokes: Strokes }) {
  const [chosen, setChosen] = useState(strokes.devices[0]!.name);
  const device = strokes.devices.find((one) => one.name === chosen) ?? strokes.devices[0]!;
  return (
    <div class="strokes">
      {strokes.devices.length > 1 && (
        <Segmented
          legend={say("common.device")}
          name="strokes-device"
          value={device.name}
          onChange={setChosen}
          choices={strokes.devices.map((one) => ({ value: one.name, title: one.title }))}
        />
      )}
      <p class="hint">{deviceText(device, strokes.b_n_s_per_mm)}</p>
      <Legend device={device} />
      {device.cases.map((one) => (
        <CaseRow key={`${device.name} ${one.name}`} one={one} />
      ))}
    </div>
  );
}

function deviceText(device: StrokeDevice, b: number): string {
  return say("strokes.device", {
    device: device.title,
    coupling: formatNumber(device.kc_n_per_mm, 2),
    encoder: formatNumber(device.resolution_um, 1),
    rate: formatNumber(device.rate_hz, 0),
    ticks: device.delay_ticks,
    damping: formatNumber(b, 2),
  });
}

function Legend({ device }: { readonly device: StrokeDevice }) {
  const tracks = device.cases[0]!.tracks;
  const lines: readonly TrackLine[] = [...tracks.map(lawLine), kIdealLine, kOracleLine, kWholeLine];
  return (
    <ul class="track-legend" aria-label={say("strokes.lines")}>
      {lines.map((line) => (
        <li key={line.label}>
          <svg class="line-sample" viewBox="0 0 24 8" aria-hidden="true">
            {line.fill === true && <rect class="area-sample" width="24" height="8" />}
            <line
              x1="0"
              y1="4"
              x2="24"
              y2="4"
              style={{ stroke: `var(${line.colorVariable})` }}
              stroke-width={line.fill === true ? 0 : line.width + 0.4}
              {...(line.dash === undefined ? {} : { "stroke-dasharray": line.dash.join(" ") })}
            />
          </svg>
          {line.label}
        </li>
      ))}
      <li>
        <svg class="mark-frame" viewBox="0 0 24 14" aria-hidden="true">
          <line class="mark-sample" x1="12" y1="0" x2="12" y2="14" stroke-dasharray="3 3" />
        </svg>
        {say("strokes.tissue_ends")}
      </li>
    </ul>
  );
}

function CaseRow({ one }: { readonly one: StrokeCase }) {
  const text = caseText(one.name);
  const track = one.tracks[0]!;
  const force = useMemo(() => drawn(one), [one]);
  return (
    <section class="stroke-case" aria-label={text.title}>
      <div class="stroke-words">
        <h3>
          {text.title} <Verdict track={track} />
        </h3>
        <p>{text.what}</p>
        <p>{sayWith("strokes.look_for", { heading: <b>{say("strokes.look_heading")}</b>, look: text.look })}</p>
      </div>
      <TrackPlot
        data={force.data}
        lines={force.lines}
        valueTitle={say("force.force_n")}
        markS={track.leaves_s}
        label={caseSentence(one)}
      />
      <details class="numbers">
        <summary>{say("strokes.more")}</summary>
        <Figures one={one} />
        <Places track={track} />
      </details>
    </section>
  );
}

function Verdict({ track }: { readonly track: StrokeTrack }) {
  const judged = track.figures.filter((figure) => figure.bound !== null);
  const missed = judged.filter((figure) => !figure.held);
  return missed.length === 0 ? (
    <Badge tone="good">{say("strokes.held", { count: judged.length })}</Badge>
  ) : (
    <Badge tone="warning">
      {say("strokes.missed", { missed: formatNumber(missed.length, 0), count: judged.length })}
    </Badge>
  );
}

function Figures({ one }: { readonly one: StrokeCase }) {
  const [first, ...others] = one.tracks;
  return (
    <TableFrame label={say("strokes.figures_of", { motion: caseText(one.name).title })}>
      <table class="dense">
        <thead>
          <tr>
            <th scope="col">{say("criteria.figure")}</th>
            <th scope="col" class="number">
              {first!.law}
            </th>
            <th scope="col" class="number">
              {say("strokes.may_be")}
            </th>
            {others.map((track) => (
              <th key={track.law} scope="col" class="number">
                {track.law}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {first!.figures.map((figure) => (
            <tr key={figure.name}>
              <th scope="row">{figureTitle(figure.name)}</th>
              <td class="number">
                {figure.held ? "" : <Badge tone="warning">{say("strokes.not_held")}</Badge>}{" "}
                {figureText(figure.value, figure.unit)}
              </td>
              <td class="number">{figure.bound === null ? "–" : figureText(figure.bound, figure.unit)}</td>
              {others.map((track) => {
                const same = track.figures.find((other) => other.name === figure.name);
                return (
                  <td key={track.law} class="number">
                    {same === undefined ? "–" : figureText(same.value, same.unit)}
                  </td>
                );
              })}
            </tr>
          ))}
        </tbody>
      </table>
    </TableFrame>
  );
}

const kPlaceLines: readonly TrackLine[] = [
  {
    get label() {
      return say("strokes.tip");
    },
    colorVariable: "--text",
    width: 1.6,
    dash: [7, 4],
  },
  {
    get label() {
      return say("document_place.bur");
    },
    colorVariable: "--plot-force",
    width: 2,
  },
];

function Places({ track }: { readonly track: StrokeTrack }) {
  const data = useMemo(
    () =>
      joined([
        { timeS: track.t_s, values: track.tip_mm },
        { timeS: track.t_s, values: track.bur_mm },
      ]),
    [track],
  );
  return (
    <>
      <p class="hint">{say("strokes.places_hint")}</p>
      <TrackPlot
        data={data}
        lines={kPlaceLines}
        valueTitle={say("strokes.place_mm")}
        markS={track.leaves_s}
        heightPx={150}
        label={say("strokes.places", { apart: formatNumber(Math.abs(track.tip_mm.at(-1)! - track.bur_mm.at(-1)!), 3) })}
      />
    </>
  );
}
