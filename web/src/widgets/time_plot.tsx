import { useEffect, useRef } from "preact/hooks";
import type uPlot from "uplot";
import type { Disposables } from "../base/disposables";
import { formatMoment } from "../base/format";
import { say } from "../base/words";
import { plotStyle, usePlot, withAlpha } from "./use_plot";

export interface PlotLine {
  readonly label: string;
  readonly unit: string;
  readonly values: readonly (number | null)[]; // null: not known there
  readonly colorVariable: string; // a CSS custom property, so that dark and light both work
  readonly dash?: readonly number[];
  readonly fill?: boolean;
  readonly width?: number;
  readonly axis: "left" | "right";
  readonly setsScale?: boolean; // false: drawn only where the others' range shows it
}

interface Props {
  readonly timeS: readonly number[];
  readonly lines: readonly PlotLine[];
  readonly leftTitle: string;
  readonly rightTitle: string;
  readonly label: string;
  readonly cursor: number; // index into timeS
  readonly onCursor: (index: number) => void;
  // Where the axis of time lies, from the plot's own left and right edge: what stands above it can
  // be put on the same axis.
  readonly onAxis?: (leftPx: number, rightPx: number) => void;
  readonly heightPx?: number;
  readonly view?: readonly [number, number] | undefined; // seconds that are shown; undefined: all
  // Asked to show `by` times as much with `atS` staying in place, what lies `byS` later, or all.
  readonly onZoom?: (atS: number, by: number) => void;
  readonly onPan?: (byS: number) => void;
  readonly onWhole?: () => void;
}

const kHeightPx = 280;
const kHeadroom = 1.08;
const kWheelStep = 1.25;
const kFineS = 0.01; // from point to point: a moment is told to the millisecond

// Lines over time with two value axes and a cursor that a press or a drag sets. A pointer that only
// passes over it shows the time there in a thin line and leaves the cursor where it is. The wheel
// zooms with Ctrl, or once the plot was pressed, since it scrolls the page otherwise; a drag with
// Shift pans; a double click shows all. The picture is for the eye: whoever shows it offers the
// numbers as a table and the cursor as a slider too.
export function TimePlot({
  timeS,
  lines,
  leftTitle,
  rightTitle,
  label,
  cursor,
  onCursor,
  onAxis,
  heightPx = kHeightPx,
  view,
  onZoom,
  onPan,
  onWhole,
}: Props) {
  const marker = useRef<HTMLDivElement | undefined>(undefined);
  const latest = useRef({ timeS, cursor, onCursor, onAxis, view, onZoom, onPan, onWhole });
  latest.current = { timeS, cursor, onCursor, onAxis, view, onZoom, onPan, onWhole };

  const { frame, plot } = usePlot(
    (element) => ({
      options: plotOptions(element, lines, leftTitle, rightTitle, heightPx),
      data: [[...timeS], ...lines.map((line) => [...line.values])],
    }),
    [timeS, lines, leftTitle, rightTitle, heightPx],
    (created, cleanup) => {
      marker.current = document.createElement("div");
      marker.current.className = "plot-cursor";
      const hover = document.createElement("div");
      hover.className = "plot-hover";
      hover.hidden = true;
      created.over.append(hover, marker.current);
      followPointer(created, cleanup, hover, timeS, () => latest.current);
      if (latest.current.view !== undefined) show(created, latest.current);
    },
    () => {
      place(plot.current, marker.current, latest.current);
      reportAxis(frame.current, plot.current, latest.current.onAxis);
    },
  );

  useEffect(() => {
    if (plot.current !== null) show(plot.current, latest.current);
  }, [plot, view]);
  useEffect(() => place(plot.current, marker.current, latest.current), [plot, view, cursor]);

  return <div class="plot" style={{ minHeight: `${heightPx}px` }} ref={frame} role="img" aria-label={label} />;
}

type Shown = Pick<Props, "timeS" | "cursor" | "view">;

function place(plot: uPlot | null, marker: HTMLElement | undefined, { timeS, cursor, view }: Shown): void {
  const time = timeS[cursor];
  if (plot === null || marker === undefined || time === undefined) return;
  const [from, to] = view ?? [-Infinity, Infinity];
  marker.hidden = time < from || time > to;
  marker.style.transform = `translateX(${plot.valToPos(time, "x").toFixed(1)}px)`;
}

function show(plot: uPlot, { timeS, view }: Shown): void {
  const [min, max] = view ?? [timeS[0] ?? 0, timeS.at(-1) ?? 0];
  if (max > min) plot.setScale("x", { min, max });
}

function reportAxis(frame: HTMLElement | null, plot: uPlot | null, report: Props["onAxis"]): void {
  if (frame === null || plot === null || report === undefined) return;
  const [outer, inner] = [frame.getBoundingClientRect(), plot.over.getBoundingClientRect()];
  report(inner.left - outer.left, outer.right - inner.right);
}

function followPointer(
  plot: uPlot,
  cleanup: Disposables,
  hover: HTMLElement,
  timeS: readonly number[],
  now: () => Pick<Props, "onCursor" | "onZoom" | "onPan" | "onWhole">,
): void {
  const xOf = (event: Event) => (event as MouseEvent).clientX - plot.over.getBoundingClientRect().left;
  const indexAt = (event: Event) => plot.posToIdx(xOf(event));
  let pressed = false; // since the pointer came
  let before: number | undefined; // where a pan was last, pixels
  cleanup.listen(plot.over, "pointermove", (event) => {
    const index = indexAt(event);
    const time = timeS[index];
    const held = ((event as PointerEvent).buttons & 1) !== 0;
    if (held && before !== undefined) {
      const x = xOf(event);
      now().onPan?.(plot.posToVal(before, "x") - plot.posToVal(x, "x"));
      before = x;
    } else if (held) now().onCursor(index);
    hover.hidden = time === undefined;
    if (time === undefined) return;
    hover.style.transform = `translateX(${plot.valToPos(time, "x").toFixed(1)}px)`;
    hover.textContent = formatMoment(time, timeS[1]! - timeS[0]! < kFineS ? 3 : 1);
  });
  cleanup.listen(plot.over, "pointerleave", () => {
    hover.hidden = true;
    pressed = false;
    before = undefined;
  });
  cleanup.listen(plot.over, "pointerdown", (event) => {
    if ((event as PointerEvent).button !== 0) return;
    pressed = true;
    before = (event as PointerEvent).shiftKey && now().onPan !== undefined ? xOf(event) : undefined;
    if (before === undefined) now().onCursor(indexAt(event));
  });
  cleanup.listen(plot.over, "pointerup", () => {
    before = undefined;
  });
  cleanup.listen(plot.over, "dblclick", () => now().onWhole?.());
  cleanup.listen(
    plot.over,
    "wheel",
    (event) => {
      const { deltaY, ctrlKey } = event as WheelEvent;
      if (now().onZoom === undefined || deltaY === 0 || !(pressed || ctrlKey)) return;
      event.preventDefault();
      now().onZoom?.(plot.posToVal(xOf(event), "x"), deltaY > 0 ? kWheelStep : 1 / kWheelStep);
    },
    { passive: false },
  );
}

function plotOptions(
  element: HTMLElement,
  lines: readonly PlotLine[],
  leftTitle: string,
  rightTitle: string,
  heightPx: number,
): uPlot.Options {
  const { color, axis } = plotStyle(element);
  const narrow = element.clientWidth < 520;
  const valueAxis = narrow ? { ...axis, size: 38 } : { ...axis, size: 46 };
  return {
    width: element.clientWidth,
    height: heightPx,
    legend: { show: false },
    cursor: { show: false },
    scales: {
      x: { time: false },
      left: { range: [0, upperEnd(lines, "left")] },
      right: { range: [0, upperEnd(lines, "right")] },
    },
    axes: [
      { ...axis, label: say("plot.time"), size: 28, values: (_, splits) => tickMoments(splits) },
      { ...valueAxis, scale: "left", label: leftTitle },
      { ...valueAxis, scale: "right", side: 1, label: rightTitle, grid: { show: false } },
    ],
    series: [
      {},
      ...lines.map(
        (line): uPlot.Series => ({
          scale: line.axis,
          stroke: color(line.colorVariable),
          width: line.width ?? 1.5,
          points: { show: false },
          ...(line.dash === undefined ? {} : { dash: [...line.dash] }),
          ...(line.fill === true ? { fill: withAlpha(color(line.colorVariable), "26") } : {}),
        }),
      ),
    ],
  };
}

function upperEnd(lines: readonly PlotLine[], axis: "left" | "right"): number {
  let largest = 0;
  for (const line of lines) {
    if (line.axis !== axis || line.setsScale === false) continue;
    for (const value of line.values) largest = Math.max(largest, value ?? 0);
  }
  return largest > 0 ? largest * kHeadroom : 1;
}

// On an axis the tenths are left out where they say nothing.
// With as many decimals as tell one from the next.
function tickMoments(splits: readonly number[]): string[] {
  const stepS = (splits[1] ?? 1) - (splits[0] ?? 0);
  const digits = Math.max(1, Math.ceil(-Math.log10(stepS) - 1e-6));
  return splits.map((seconds) =>
    digits > 1 ? formatMoment(seconds, digits) : formatMoment(seconds).replace(/[.,]0$/, ""),
  );
}
