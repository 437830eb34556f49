import { useMemo, useRef, useState } from "preact/hooks";
import type { Series } from "../../api/types";
import type { Loaded } from "../../api/use_request";
import { formatDuration, formatMoment, formatQuantity } from "../../base/format";
import { Card, ErrorNotice, Loading, TableFrame } from "../../widgets/basics";
import { CopyText } from "../../widgets/copy";
import { type PlotLine, TimePlot } from "../../widgets/time_plot";
import { boundLine, type Mark } from "./moments";
import { RangePanel } from "./range_panel";

const kTableRows = 40;
// Beside tooth and timeline there is little height on a small screen.
const kHeightPx = window.innerHeight < 800 ? 150 : 200;

interface Props {
  readonly series: Loaded<Series>;
  readonly cursor: number;                      // the step that the moment lies in
  readonly timeS: number;                       // the moment
  readonly range: readonly [number, number] | undefined;  // A to B, seconds
  readonly marks: readonly Mark[];
  readonly chosen: string | undefined;          // id of a remark
  readonly onMark: (mark: Mark) => void;
  readonly onCursor: (index: number) => void;
  readonly onRetry: () => void;
  readonly link: () => string;                  // the address of this moment, looked at as now
}

export function ForcePanel({ series, onRetry, ...rest }: Props) {
  return (
    <Card title="Force and removal over time" className="force-card">
      {series.state === "loading" && <Loading what="the force record" />}
      {series.state === "failed" && <ErrorNotice title="The force record could not be loaded" message={series.error.message} onRetry={onRetry} />}
      {series.state === "ready" && (series.value.t_s.length === 0
        ? <p class="empty">The attempt has no recorded step.</p>
        : <LoadedForce series={series.value} {...rest} />)}
    </Card>
  );
}

function LoadedForce({ series, cursor, timeS, range, marks, chosen, onMark, onCursor, link }: Omit<Props, "series" | "onRetry"> & { readonly series: Series }) {
  const lines = useMemo(() => linesOf(series), [series]);
  const last = series.t_s.length - 1;
  const at = Math.min(cursor, last);
  const axis = useRef<HTMLDivElement>(null);
  const align = (leftPx: number, rightPx: number) => {
    axis.current?.style.setProperty("--axis-left", `${leftPx}px`);
    axis.current?.style.setProperty("--axis-right", `${rightPx}px`);
  };
  return (
    <div class="time-axis" ref={axis}>
      {marks.length > 0 && (
        <div class="marks" role="group" aria-label="Remarks along the time">
          {marks.map((mark) => (
            <button key={mark.annotation.id} type="button" class={mark.annotation.id === chosen ? "mark chosen" : "mark"} style={{ left: `${100 * mark.share}%` }}
                    aria-pressed={mark.annotation.id === chosen} onClick={() => onMark(mark)}><span class="hidden">Remark </span>{mark.number}</button>
          ))}
        </div>
      )}
      <div class="timeline">
        <label class="hidden" for="timeline">Time in the attempt</label>
        <input id="timeline" type="range" min={0} max={last} step={1} value={at}
               aria-valuetext={lines.reduce((text, line) => `${text}, ${line.label.toLowerCase()} ${readText(line, at)}`,
                                            `${formatMoment(series.t_s[at] ?? 0)}`)}
               onInput={(event) => onCursor(Number(event.currentTarget.value))} />
      </div>
      <TimePlot timeS={series.t_s} lines={lines} leftTitle="Force (N)" rightTitle="Removed (mm³)" label={plotText(series)}
                cursor={at} onCursor={onCursor} onAxis={align} heightPx={kHeightPx} />
      <MomentLinkButton link={link} />
      <Readout lines={lines} timeS={timeS} index={at} />
      <RangePanel series={series} range={range} />
      <details class="numbers">
        <summary>The same as a table</summary>
        <SeriesTable series={series} />
      </details>
    </div>
  );
}

// The address is shown as well: where the browser does not allow copying, it can be taken from there.
function MomentLinkButton({ link }: { readonly link: () => string }) {
  const [shown, setShown] = useState<string>();
  return (
    <div class="moment-link no-print">
      <button type="button" class="button small quiet" onClick={() => setShown(link())}>Link to this moment</button>
      {shown !== undefined && <CopyText key={shown} text={shown} what="the link" />}
    </div>
  );
}

function linesOf(series: Series): PlotLine[] {
  const bound = boundLine(series);
  return [
    { label: "Removed volume", unit: "mm3", values: series.removed_mm3, colorVariable: "--plot-removed", axis: "right", fill: true, dash: [7, 4] },
    { label: "Largest force", unit: "N", values: series.force_n, colorVariable: "--plot-force", axis: "left", width: 1 },
    { label: "Mean force", unit: "N", values: series.force_mean_n, colorVariable: "--plot-mean", axis: "left", width: 2.2 },
    ...(bound === undefined ? [] : [{ label: "Device's limit", unit: "N", values: bound, colorVariable: "--plot-bound", axis: "left" as const,
                                      dash: [2, 3], setsScale: false }]),
  ];
}

function Readout({ lines, timeS, index }: { readonly lines: readonly PlotLine[]; readonly timeS: number; readonly index: number }) {
  return (
    <dl class="readout">
      <div><dt>Time</dt><dd>{formatMoment(timeS)}</dd></div>
      {lines.map((line) => (
        <div key={line.label}>
          <dt><LineSample line={line} />{line.label}</dt>
          <dd>{readText(line, index)}</dd>
        </div>
      ))}
    </dl>
  );
}

// "–" where nothing is known.
function readText({ values, unit }: PlotLine, index: number): string {
  return formatQuantity(values[index] ?? Number.NaN, unit);
}

function LineSample({ line }: { readonly line: PlotLine }) {
  return (
    <svg class="line-sample" viewBox="0 0 24 8" aria-hidden="true">
      <line x1="0" y1="4" x2="24" y2="4" style={{ stroke: `var(${line.colorVariable})` }} stroke-width={(line.width ?? 1.5) + 0.5}
            {...(line.dash === undefined ? {} : { "stroke-dasharray": line.dash.join(" ") })} />
    </svg>
  );
}

function SeriesTable({ series }: { readonly series: Series }) {
  const stride = Math.max(1, Math.ceil(series.t_s.length / kTableRows));
  const rows = series.t_s.map((_, i) => i).filter((i) => i % stride === 0 || i === series.t_s.length - 1);
  return (
    <TableFrame label="Force and removal as a table">
      <table class="dense">
        <thead>
          <tr><th scope="col" class="number">Time</th><th scope="col" class="number">Largest force (N)</th>
              <th scope="col" class="number">Mean force (N)</th><th scope="col" class="number">Removed (mm³)</th></tr>
        </thead>
        <tbody>
          {rows.map((i) => (
            <tr key={i}>
              <th scope="row" class="number">{formatMoment(series.t_s[i] ?? 0)}</th>
              <td class="number">{(series.force_n[i] ?? 0).toFixed(2)}</td>
              <td class="number">{(series.force_mean_n[i] ?? 0).toFixed(2)}</td>
              <td class="number">{(series.removed_mm3[i] ?? 0).toFixed(2)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </TableFrame>
  );
}

function plotText(series: Series): string {
  const largest = series.force_n.reduce((a, b) => Math.max(a, b), 0);
  const at = series.t_s[series.force_n.indexOf(largest)] ?? 0;
  return `Force and removed volume over ${formatDuration(series.t_s.at(-1) ?? 0)}. The largest force is ` +
         `${formatQuantity(largest, "N")} at ${formatMoment(at)}; ${formatQuantity(series.removed_mm3.at(-1) ?? 0, "mm3")} were removed in all.`;
}
