import { say } from "../base/words";
import type uPlot from "uplot";
import { plotStyle, usePlot, withAlpha } from "./use_plot";
import type { Joined, TrackLine } from "./strokes/tracks";

interface Props {
  readonly data: Joined; // one column for each line
  readonly lines: readonly TrackLine[];
  readonly valueTitle: string;
  readonly markS?: number | null; // an upright line at this time
  readonly label: string;
  readonly heightPx?: number;
}

const kHeightPx = 210;
const kHeadroom = 0.06;

// Lines over time, of either sign, in one frame of a row of small ones. The picture is for the eye:
// the caller gives the same in words and numbers.
export function TrackPlot({ data, lines, valueTitle, markS = null, label, heightPx = kHeightPx }: Props) {
  const { frame } = usePlot(
    (element) => ({
      options: plotOptions(element, data, lines, valueTitle, markS, heightPx),
      data: [[...data.timeS], ...data.columns.map((column) => [...column])] as uPlot.AlignedData,
    }),
    [data, lines, valueTitle, markS, heightPx],
  );

  return <div class="plot" ref={frame} role="img" aria-label={label} />;
}

function plotOptions(
  element: HTMLElement,
  data: Joined,
  lines: readonly TrackLine[],
  valueTitle: string,
  markS: number | null,
  heightPx: number,
): uPlot.Options {
  const { color, axis } = plotStyle(element);
  const mark = (plot: uPlot) => {
    if (markS === null) return;
    const x = Math.round(plot.valToPos(markS, "x", true));
    const { top, height } = plot.bbox;
    plot.ctx.save();
    plot.ctx.strokeStyle = color("--line-strong");
    plot.ctx.lineWidth = devicePixelRatio;
    plot.ctx.setLineDash([4 * devicePixelRatio, 4 * devicePixelRatio]);
    plot.ctx.beginPath();
    plot.ctx.moveTo(x, top);
    plot.ctx.lineTo(x, top + height);
    plot.ctx.stroke();
    plot.ctx.restore();
  };
  return {
    width: element.clientWidth,
    height: heightPx,
    legend: { show: false },
    cursor: { show: false },
    hooks: { drawAxes: [mark] },
    scales: { x: { time: false }, value: { range: valueRange(data) } },
    axes: [
      { ...axis, label: say("plot.seconds"), size: 34 },
      { ...axis, scale: "value", label: valueTitle, size: 46 },
    ],
    series: [
      {},
      ...lines.map(
        (line): uPlot.Series => ({
          scale: "value",
          stroke: color(line.colorVariable),
          width: line.width,
          points: { show: false },
          spanGaps: true,
          ...(line.dash === undefined ? {} : { dash: [...line.dash] }),
          ...(line.fill === true ? { fill: withAlpha(color(line.colorVariable), "2e") } : {}),
        }),
      ),
    ],
  };
}

// Zero is always shown.
function valueRange(data: Joined): [number, number] {
  let low = 0;
  let high = 0;
  for (const column of data.columns) {
    for (const value of column) {
      if (value === null) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  if (high === low) return [-1, 1];
  const room = kHeadroom * (high - low);
  return [low - room, high + room];
}
