import type { Exercise, Series } from "../../api/types";
import { say, sayIf } from "../../base/words";
import type { PlotLine } from "../../widgets/time_plot";
import { boundLine } from "./moments";
import { speeds } from "./speed";

// The lines of the plots over time.

export function linesOf(series: Series): PlotLine[] {
  const bound = boundLine(series);
  const computed = heldBack(series);
  return [
    {
      label: say("plot.removed_volume"),
      unit: "mm3",
      values: series.removed_mm3,
      colorVariable: "--plot-removed",
      axis: "right",
      fill: true,
      dash: [7, 4],
    },
    {
      label: say("plot.largest_force"),
      unit: "N",
      values: series.force_n,
      colorVariable: "--plot-force",
      axis: "left",
      width: 1,
    },
    {
      label: say("plot.mean_force"),
      unit: "N",
      values: series.force_mean_n,
      colorVariable: "--plot-mean",
      axis: "left",
      width: 2.2,
    },
    ...(computed === undefined
      ? []
      : [
          {
            label: say("plot.computed_force"),
            unit: "N",
            values: computed,
            colorVariable: "--plot-computed",
            axis: "left" as const,
            width: 1,
            dash: [3, 3],
          },
        ]),
    ...(bound === undefined
      ? []
      : [
          {
            label: say("plot.device_limit"),
            unit: "N",
            values: bound,
            colorVariable: "--plot-bound",
            axis: "left" as const,
            dash: [2, 3],
            setsScale: false,
          },
        ]),
  ];
}

const kHeldBack = 0.02; // of the force, and
const kHeldBackN = 0.02; // newton: less is rounding

// What the force would have been, where limiter or device held some of it back; undefined where
// they never did.
function heldBack({ computed_n: computed, force_n: sent }: Series): readonly number[] | undefined {
  return computed.some((force, i) => force > (1 + kHeldBack) * sent[i]! + kHeldBackN) ? computed : undefined;
}

const kTissueLines: ReadonlyArray<readonly [string, readonly number[]]> = [
  ["--plot-removed", [7, 4]],
  ["--plot-mean", [2, 3]],
  ["--plot-bound", [10, 3, 2, 3]],
];

// How fast the tip went, and what went of each tissue.
export function moreLinesOf(series: Series): PlotLine[] {
  return [
    {
      label: say("plot.tip_speed"),
      unit: "mm/s",
      values: speeds(series),
      colorVariable: "--plot-force",
      axis: "left",
      width: 1.2,
    },
    ...Object.entries(series.removed_by_tissue).map(([tissue, values], i): PlotLine => {
      const [colorVariable, dash] = kTissueLines[i % kTissueLines.length]!;
      return {
        label: say("force.tissue_removed", { tissue: sayIf(`tooth_tissue.${tissue}`) ?? tissue }),
        unit: "mm3",
        values,
        colorVariable,
        dash,
        axis: "right",
        width: 2,
      };
    }),
  ];
}

type Target = Exercise["target"];

// How deep the tip was below the opening of what is to be cut, and how far from the pulp.
export function deepLinesOf(series: Series, target: Target | undefined): PlotLine[] {
  const opening = target?.landmark_um?.[2];
  const above = Math.max(0, ...(target?.parts ?? []).map((part) => part.top_um?.[2] ?? 0));
  return [
    ...(opening === undefined
      ? []
      : [
          {
            label: say("plot.depth"),
            unit: "mm",
            colorVariable: "--plot-mean",
            axis: "left" as const,
            width: 1.6,
            values: series.anchor_mm.map(([, , z]) => Math.max(0, (opening + above) / 1000 - z!)),
          },
        ]),
    ...(series.pulp_mm === undefined
      ? []
      : [
          {
            label: say("plot.pulp"),
            unit: "mm",
            colorVariable: "--plot-computed",
            axis: "right" as const,
            width: 1.6,
            dash: [7, 4],
            values: series.pulp_mm,
          },
        ]),
  ];
}

export function moreText(lines: readonly PlotLine[]): string {
  return say("force.more_over_time", { lines: lines.map(({ label }) => label).join(", ") });
}
