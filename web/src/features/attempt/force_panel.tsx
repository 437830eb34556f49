import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { exerciseTitle } from "../../api/builtin_words";
import type { Series } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { downloadFile, fileName } from "../../base/download";
import { formatDuration, formatFixed, formatMoment, formatQuantity, unitText } from "../../base/format";
import { say } from "../../base/words";
import type { FilmLink } from "../../tooth/link";
import type { ModelFormat } from "../../tooth/messages";
import { Card, Folded, TableFrame, Waits } from "../../widgets/basics";
import { CopyText } from "../../widgets/copy";
import { type PlotLine, TimePlot } from "../../widgets/time_plot";
import { stepAt, stepIn } from "./clock";
import { type CloseUp, closeUp, ticksFor } from "./close_up";
import type { Mark } from "./moments";
import { deepLinesOf, linesOf, moreLinesOf, moreText } from "./plot_lines";
import { PrintButton } from "./print_report";
import { RangePanel } from "./range_panel";
import { SpanLegend, SpanStrip } from "./span_strip";
import type { Review } from "./use_review";
import { VideoButton } from "./video_button";
import { kZoomStep, panned, showing, type View, zoomed } from "./view";

const kTableRows = 40;
// Beside tooth and timeline there is little height on a small screen.
const kLow = window.innerHeight < 800;
const kHeightPx = kLow ? 112 : 178;
// Of an axis, along which a low plot has no room for words; its lines are named below.
const axisTitle = (title: string, unit: string): string => (kLow ? unitText(unit) : title);

export function ForcePanel({ review }: { readonly review: Review }) {
  const { loaded, reload } = review.series;
  return (
    <Card title={say("force.title")} className="force-card">
      <Waits loaded={loaded} reload={reload} what={say("loading.force")} failed={say("force.failed")} />
      {loaded.state === "ready" &&
        (loaded.value.t_s.length === 0 ? (
          <p class="empty">{say("force.no_step")}</p>
        ) : (
          <LoadedForce series={loaded.value} review={review} />
        ))}
    </Card>
  );
}

function LoadedForce({ series, review }: { readonly series: Series; readonly review: Review }) {
  const {
    client,
    attempt,
    cursor,
    momentS: timeS,
    marks,
    spans,
    chosen,
    plots,
    choose,
    control,
    setCursor: onCursor,
    setTimeS: onTime,
  } = review;
  const last = series.t_s.length - 1;
  const at = Math.min(cursor, last);
  const whole = useMemo((): View => [series.t_s[0] ?? 0, series.t_s.at(-1) ?? 0], [series]);
  const [view, setView] = useState<View>();
  // Moving the moment past the edge moves the visible part too.
  useEffect(() => setView((was) => showing(whole, was, series.t_s[at] ?? 0)), [whole, series, at]);
  const wanted = ticksFor(series, view);
  const { loaded: near } = useRequest(wanted === undefined ? undefined : `${attempt.id} ${wanted[0]}`, (signal) =>
    client.ticks(attempt.id, ...wanted!, signal),
  );
  const close = useMemo(
    () => (near.state === "ready" && near.value.time_ticks.length > 0 ? closeUp(near.value, series) : undefined),
    [near, series],
  );
  const lines = useMemo(() => linesOf(series), [series]);
  const text = useMemo(() => plotText(series), [series]);
  const zoom = (atS: number, by: number) => setView(zoomed(whole, view, atS, by));
  plots.zoom = (direction) =>
    direction === 0 ? setView(undefined) : zoom(series.t_s[at] ?? 0, kZoomStep ** -direction);
  const [fromS, toS] = view ?? whole;
  const shown =
    view === undefined
      ? marks
      : marks.filter((mark) => (series.t_s[mark.step] ?? 0) >= fromS && (series.t_s[mark.step] ?? 0) <= toS);
  const shareOf = (mark: Mark) =>
    view === undefined ? mark.share : ((series.t_s[mark.step] ?? 0) - fromS) / (toS - fromS);
  const digits = close === undefined ? 1 : 2;
  const shownText = say(close === undefined ? "force.shown" : "force.shown_ticks", {
    from: formatMoment(fromS, digits),
    to: formatMoment(toS, digits),
  });
  const [more, setMore] = useState(false);
  plots.more = () => setMore((was) => !was);
  const moreLines = useMemo(() => (more ? moreLinesOf(series) : []), [series, more]);
  const { loaded: asked } = useRequest(more ? attempt.exercise.id : undefined, (signal) =>
    client.tagged("GET", "/exercises/{id}", { id: attempt.exercise.id, signal }),
  );
  const deepLines = useMemo(
    () => (more ? deepLinesOf(series, asked.state === "ready" ? asked.value.value.target : undefined) : []),
    [series, more, asked],
  );
  const moved = {
    view,
    onZoom: zoom,
    onPan: (byS: number) => setView(panned(whole, view, byS)),
    onWhole: () => setView(undefined),
  };
  const axis = useRef<HTMLDivElement>(null);
  const align = (leftPx: number, rightPx: number) => {
    axis.current?.style.setProperty("--axis-left", `${leftPx}px`);
    axis.current?.style.setProperty("--axis-right", `${rightPx}px`);
  };
  return (
    <div class="time-axis" ref={axis}>
      {marks.length > 0 && (
        <div class="marks" role="group" aria-label={say("force.remarks")}>
          {shown.map((mark) => (
            <button
              key={mark.annotation.id}
              type="button"
              class={mark.annotation.id === chosen ? "mark chosen" : "mark"}
              style={{ left: `${100 * shareOf(mark)}%` }}
              aria-pressed={mark.annotation.id === chosen}
              onClick={() => choose(mark)}
            >
              <span class="hidden">{say("remarks.one")}</span>
              {mark.number}
            </button>
          ))}
        </div>
      )}
      {spans.length > 0 && <SpanStrip spans={spans} fromS={fromS} toS={toS} onTime={onTime} />}
      <div class="timeline">
        <label class="hidden" for="timeline">
          {say("live.time_in")}
        </label>
        <input
          id="timeline"
          type="range"
          min={view === undefined ? 0 : stepAt(series, fromS)}
          max={view === undefined ? last : stepAt(series, toS)}
          step={1}
          value={at}
          // A screen reader says the moment once it stays.
          aria-valuetext={
            control?.playing === true
              ? say("playback.playing")
              : lines.reduce(
                  (text, line) => `${text}, ${line.label} ${readText(line, at)}`,
                  `${formatMoment(series.t_s[at] ?? 0)}`,
                )
          }
          onInput={(event) => onCursor(Number(event.currentTarget.value))}
        />
      </div>
      {close === undefined ? (
        <TimePlot
          key="series"
          timeS={series.t_s}
          lines={lines}
          leftTitle={axisTitle(say("force.force_n"), "n")}
          rightTitle={axisTitle(say("force.removed_mm3"), "mm3")}
          label={text}
          cursor={at}
          onCursor={onCursor}
          onAxis={align}
          heightPx={kHeightPx}
          {...moved}
        />
      ) : (
        <CloseUpPlot
          close={close}
          timeS={timeS}
          onTime={onTime}
          leftTitle={axisTitle(say("force.force_n"), "n")}
          rightTitle={axisTitle(say("force.removed_mm3"), "mm3")}
          label={`${text} ${shownText}`}
          onAxis={align}
          {...moved}
        />
      )}
      {more && (
        <TimePlot
          timeS={series.t_s}
          lines={moreLines}
          leftTitle={axisTitle(say("force.speed"), "mm/s")}
          rightTitle={axisTitle(say("force.removed_mm3"), "mm3")}
          label={moreText(moreLines)}
          cursor={at}
          onCursor={onCursor}
          heightPx={kHeightPx}
          {...moved}
        />
      )}
      {deepLines.length > 0 && (
        <TimePlot
          timeS={series.t_s}
          lines={deepLines}
          leftTitle={axisTitle(say("force.depth_mm"), "mm")}
          rightTitle={axisTitle(say("force.pulp_mm"), "mm")}
          label={moreText(deepLines)}
          cursor={at}
          onCursor={onCursor}
          heightPx={kHeightPx}
          {...moved}
        />
      )}
      {view !== undefined && (
        <p class="hint view-of" role="status">
          {shownText}{" "}
          <button type="button" class="button small quiet" onClick={() => setView(undefined)}>
            {say("attempts.show_all")}
          </button>
        </p>
      )}
      {spans.length > 0 && <SpanLegend spans={spans} />}
      {series.felt_error !== undefined && (
        <p class="hint">{say("force.felt_error", { percent: Math.round(100 * series.felt_error) })}</p>
      )}
      <button type="button" class="button small quiet no-print" aria-pressed={more} onClick={() => setMore(!more)}>
        {say("force.more")}
      </button>
      <MomentLinkButton link={review.link} review={review} />
      {review.teacher && <PrintButton quiet look={() => review.look} />}
      <Readout lines={[...lines, ...moreLines, ...deepLines]} timeS={timeS} index={at} />
      <RangePanel series={series} range={review.range} />
      <Folded title={say("force.as_table")} content={() => <SeriesTable series={series} />} />
    </div>
  );
}

// The same lines, tick by tick. The cursor is at the tick of the moment.
function CloseUpPlot({
  close,
  timeS,
  onTime,
  ...rest
}: Omit<Parameters<typeof TimePlot>[0], "timeS" | "lines" | "cursor" | "onCursor" | "heightPx"> & {
  readonly close: CloseUp;
  readonly timeS: number;
  readonly onTime: (timeS: number) => void;
}) {
  const lines = useMemo(
    (): PlotLine[] => [
      {
        label: say("plot.removed_volume"),
        unit: "mm3",
        values: close.removedMm3,
        colorVariable: "--plot-removed",
        axis: "right",
        fill: true,
        dash: [7, 4],
      },
      {
        label: say("plot.force"),
        unit: "N",
        values: close.forceN,
        colorVariable: "--plot-force",
        axis: "left",
        width: 1.4,
      },
      ...(close.computedN === undefined
        ? []
        : [
            {
              label: say("plot.computed_force"),
              unit: "N",
              values: close.computedN,
              colorVariable: "--plot-computed",
              axis: "left" as const,
              width: 1,
              dash: [3, 3],
            },
          ]),
    ],
    [close],
  );
  const at = stepIn(close.timeS, timeS);
  return (
    <TimePlot
      {...rest}
      timeS={close.timeS}
      lines={lines}
      cursor={at}
      onCursor={(index) => onTime(close.timeS[index] ?? timeS)}
      heightPx={kHeightPx}
    />
  );
}

const kModelTypes = { stl: "model/stl", glb: "model/gltf-binary" } as const;

// The address is shown as well: where the browser does not allow copying, it can be taken from
// there.
function MomentLinkButton({ link, review }: { readonly link: () => string; readonly review: Review }) {
  const [shown, setShown] = useState<string>();
  const [lost, setLost] = useState(false); // what saves the tooth could not be loaded
  const { control, attempt } = review;
  const { film } = control?.playback ?? {};
  const names = [exerciseTitle(attempt.exercise), attempt.person.display_name] as const;
  const save = async (from: FilmLink, as: ModelFormat) => {
    const name = fileName(...names, formatMoment(review.momentS).replace(":", "m"));
    const model = await from.model(as);
    setLost(!model.ok);
    if (model.ok) downloadFile(`${name}.${as}`, kModelTypes[as], model.value);
  };
  return (
    <div class="moment-link no-print">
      {film !== undefined && control?.playback.drawn === true && (
        <>
          <button type="button" class="button small quiet" onClick={() => void save(film, "stl")}>
            {say("force.save_stl")}
          </button>
          <button type="button" class="button small quiet" onClick={() => void save(film, "glb")}>
            {say("force.save_glb")}
          </button>
        </>
      )}
      {control?.playback.whole === true && (
        <VideoButton control={control} picture={() => review.look.stream?.()} fileName={fileName(...names, "video")} />
      )}
      <button type="button" class="button small quiet" onClick={() => setShown(link())}>
        {say("force.link")}
      </button>
      {shown !== undefined && <CopyText key={shown} text={shown} what={say("copy.link")} />}
      {lost && <p role="alert">{say("error.unreachable")}</p>}
    </div>
  );
}

function Readout({
  lines,
  timeS,
  index,
}: {
  readonly lines: readonly PlotLine[];
  readonly timeS: number;
  readonly index: number;
}) {
  return (
    <dl class="readout">
      <div>
        <dt>{say("common.time")}</dt>
        <dd>{formatMoment(timeS)}</dd>
      </div>
      {lines.map((line) => (
        <div key={line.label}>
          <dt>
            <LineSample line={line} />
            {line.label}
          </dt>
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
      <line
        x1="0"
        y1="4"
        x2="24"
        y2="4"
        style={{ stroke: `var(${line.colorVariable})` }}
        stroke-width={(line.width ?? 1.5) + 0.5}
        {...(line.dash === undefined ? {} : { "stroke-dasharray": line.dash.join(" ") })}
      />
    </svg>
  );
}

function SeriesTable({ series }: { readonly series: Series }) {
  const stride = Math.max(1, Math.ceil(series.t_s.length / kTableRows));
  const rows = series.t_s.map((_, i) => i).filter((i) => i % stride === 0 || i === series.t_s.length - 1);
  return (
    <TableFrame label={say("force.table")}>
      <table class="dense">
        <thead>
          <tr>
            <th scope="col" class="number">
              {say("common.time")}
            </th>
            <th scope="col" class="number">
              {say("force.largest_n")}
            </th>
            <th scope="col" class="number">
              {say("force.mean_n")}
            </th>
            <th scope="col" class="number">
              {say("force.removed_mm3")}
            </th>
          </tr>
        </thead>
        <tbody>
          {rows.map((i) => (
            <tr key={i}>
              <th scope="row" class="number">
                {formatMoment(series.t_s[i] ?? 0)}
              </th>
              <td class="number">{formatFixed(series.force_n[i] ?? 0, 2)}</td>
              <td class="number">{formatFixed(series.force_mean_n[i] ?? 0, 2)}</td>
              <td class="number">{formatFixed(series.removed_mm3[i] ?? 0, 2)}</td>
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
  return say("force.text", {
    span: formatDuration(series.t_s.at(-1) ?? 0),
    force: formatQuantity(largest, "N"),
    moment: formatMoment(at),
    volume: formatQuantity(series.removed_mm3.at(-1) ?? 0, "mm3"),
  });
}
