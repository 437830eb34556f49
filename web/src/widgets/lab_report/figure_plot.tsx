import type uPlot from "uplot";
import type { LabMap, LabPlot, LabSeries } from "../../api/lab_report";
import { kVerdicts } from "../../api/lab_report";
import { say } from "../../base/words";
import { plotStyle, usePlot } from "../use_plot";
import {
  edgesOf,
  kColourVariables,
  kVerdictVariables,
  mapSentence,
  plotOfMap,
  plotSentence,
  rangeOf,
  rowsOf,
  tickText,
  ticksOf,
} from "./plot_data";

const kHeightPx = 360;
const kDash = [7, 4];

// Points and lines over linear or logarithmic axes, with the names of its series below or beside
// the points.
export function FigurePlot({ plot }: { readonly plot: LabPlot }) {
  return <Figure plot={plot} sentence={plotSentence(plot)} />;
}

// A grid of verdicts with curves over it.
export function VerdictMap({ map }: { readonly map: LabMap }) {
  return <Figure plot={plotOfMap(map)} map={map} sentence={mapSentence(map)} />;
}

function Figure({ plot, map, sentence }: { readonly plot: LabPlot; readonly map?: LabMap; readonly sentence: string }) {
  const { frame } = usePlot(
    (element) => {
      const { x, columns } = rowsOf(plot.series);
      // uPlot draws nothing, not even axes, without a point.
      const data =
        x.length > 0
          ? [x, ...columns]
          : [[map?.x[0] ?? 1], ...(plot.series.length > 0 ? plot.series : [undefined]).map(() => [null])];
      return { options: optionsOf(element, plot, map), data: data as uPlot.AlignedData };
    },
    [plot.title, map],
  );
  return (
    <figure class="lab-figure">
      <figcaption>{plot.title}</figcaption>
      <div class="plot" ref={frame} role="img" aria-label={sentence} />
      <Legend plot={plot} map={map} />
      {map !== undefined && map.note !== "" && <p class="hint">{map.note}</p>}
    </figure>
  );
}

function Legend({ plot, map }: { readonly plot: LabPlot; readonly map: LabMap | undefined }) {
  return (
    <ul class="track-legend" aria-label={say("strokes.lines")}>
      {map !== undefined &&
        kVerdicts.map((verdict) => (
          <li key={verdict}>
            <svg class="line-sample" viewBox="0 0 24 8" aria-hidden="true">
              <rect width="24" height="8" style={{ fill: `var(${kVerdictVariables[verdict]})` }} />
            </svg>
            {verdict}
          </li>
        ))}
      {plot.series
        .filter((series) => series.label !== "" && !series.beside)
        .map((series) => (
          <li key={series.label}>
            <Sample series={series} />
            {series.label}
          </li>
        ))}
    </ul>
  );
}

function Sample({ series }: { readonly series: LabSeries }) {
  const stroke = `var(${kColourVariables[series.colour]})`;
  const dots = series.style === "dots" || series.style === "rings";
  return (
    <svg class="line-sample" viewBox="0 0 24 8" aria-hidden="true">
      {dots ? (
        <circle
          cx="12"
          cy="4"
          r="3"
          stroke-width="1.5"
          style={{ stroke, fill: series.style === "dots" ? stroke : "none" }}
        />
      ) : (
        <line
          x1="0"
          y1="4"
          x2="24"
          y2="4"
          stroke-width="2"
          style={{ stroke }}
          {...(series.style === "dashes" ? { "stroke-dasharray": kDash.join(" ") } : {})}
        />
      )}
    </svg>
  );
}

function optionsOf(element: HTMLElement, plot: LabPlot, map: LabMap | undefined): uPlot.Options {
  const { color, axis } = plotStyle(element);
  const [edgesX, edgesY] = [map === undefined ? [] : edgesOf(map.x), map === undefined ? [] : edgesOf(map.y)];
  const range = (of: "x" | "y", log: boolean, edges: readonly number[]): [number, number] =>
    edges.length > 0
      ? [edges[0]!, edges.at(-1)!]
      : rangeOf(
          plot.series.flatMap((series) => series[of]),
          log,
        );
  const rangeX = range("x", plot.log_x, edgesX);
  const rangeY = range("y", plot.log_y, edgesY);
  const ticks = (
    log: boolean,
    [low, high]: [number, number],
    label: string,
    size: number,
    scale: string,
  ): uPlot.Axis => ({
    ...axis,
    scale,
    label,
    size,
    splits: () => ticksOf(low, high, log),
    filter: (_, splits) => splits,
    values: (_, splits) => splits.map(tickText),
  });

  const cells = (drawn: uPlot) => {
    if (map === undefined) return;
    drawn.ctx.save();
    const px = edgesX.map((edge) => drawn.valToPos(edge, "x", true));
    const py = edgesY.map((edge) => drawn.valToPos(edge, "y", true));
    map.cells.forEach((verdict, index) => {
      const [column, row] = [index % map.x.length, Math.floor(index / map.x.length)];
      drawn.ctx.fillStyle = color(kVerdictVariables[verdict]);
      drawn.ctx.fillRect(
        px[column]!,
        py[row + 1]!,
        px[column + 1]! - px[column]! - devicePixelRatio,
        py[row]! - py[row + 1]! - devicePixelRatio,
      );
    });
    drawn.ctx.restore();
  };
  const names = (drawn: uPlot) => {
    drawn.ctx.save();
    drawn.ctx.font = `${11 * devicePixelRatio}px ${getComputedStyle(element).fontFamily}`;
    drawn.ctx.fillStyle = color("--text");
    drawn.ctx.textAlign = "left";
    plot.series
      .filter((series) => series.beside && series.x.length > 0)
      .forEach((series, index) => {
        // Above and below in turn, so that neighbours' names do not cover each other.
        const up = index % 2 === 0;
        drawn.ctx.fillText(
          series.label,
          drawn.valToPos(series.x.at(-1)!, "x", true) + 7 * devicePixelRatio,
          drawn.valToPos(series.y.at(-1)!, "y", true) + (up ? -7 : 15) * devicePixelRatio,
        );
      });
    drawn.ctx.restore();
  };

  const series = plot.series.map((one): uPlot.Series => {
    const stroke = color(kColourVariables[one.colour]);
    const dots = one.style === "dots" || one.style === "rings";
    return {
      scale: "y",
      stroke,
      width: dots ? 0 : 1.6,
      spanGaps: true,
      ...(one.style === "dashes" ? { dash: kDash } : {}),
      ...(dots ? { paths: () => null } : {}),
      points: dots
        ? { show: true, size: 8, width: 1.5, stroke, fill: one.style === "dots" ? stroke : "transparent" }
        : { show: false },
    };
  });
  return {
    width: element.clientWidth,
    height: kHeightPx,
    legend: { show: false },
    cursor: { show: false },
    hooks: { drawAxes: [cells], draw: [names] },
    scales: {
      x: { time: false, distr: plot.log_x ? 3 : 1, range: rangeX },
      y: { distr: plot.log_y ? 3 : 1, range: rangeY },
    },
    axes: [ticks(plot.log_x, rangeX, plot.x_label, 34, "x"), ticks(plot.log_y, rangeY, plot.y_label, 58, "y")],
    series: [{}, ...(series.length > 0 ? series : [{ scale: "y" }])],
  };
}
