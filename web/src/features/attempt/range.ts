import type { Series } from "../../api/types";

// What happened in a part of an attempt, in figures. Steps are equally long, so each counts the
// same. Loaded when somebody opens them, so it imports nothing that other parts share.

export interface RangeRow {
  readonly what: "largest_force" | "mean_force" | "tip_speed";
  readonly unit: string;
  readonly mean: number;
  readonly peak: number;
  readonly rms: number; // root of the mean square
  readonly p95: number; // the least value that 95 % of the steps do not exceed
}

// Of steps `from` to `to`, both counted. `speed`: of all steps (speed.ts).
export function rangeRows(series: Series, speed: readonly number[], from: number, to: number): RangeRow[] {
  const part = (values: readonly number[]) => values.slice(from, to + 1);
  return [
    row("largest_force", "N", part(series.force_n)),
    row("mean_force", "N", part(series.force_mean_n)),
    row("tip_speed", "mm/s", part(speed)),
  ];
}

// mm³ that went in the steps, in all and by tissue.
export function removedIn(series: Series, from: number, to: number): readonly (readonly [string, number])[] {
  const gone = (values: readonly number[]) => (values[to] ?? 0) - (from === 0 ? 0 : (values[from - 1] ?? 0));
  return [
    ["all", gone(series.removed_mm3)],
    ...Object.entries(series.removed_by_tissue).map(([tissue, values]) => [tissue, gone(values)] as const),
  ];
}

function row(what: RangeRow["what"], unit: string, values: readonly number[]): RangeRow {
  const n = Math.max(1, values.length);
  const sorted = [...values].sort((a, b) => a - b);
  return {
    what,
    unit,
    mean: values.reduce((sum, value) => sum + value, 0) / n,
    peak: sorted.at(-1) ?? 0,
    rms: Math.sqrt(values.reduce((sum, value) => sum + value * value, 0) / n),
    p95: sorted[Math.max(0, Math.ceil(0.95 * sorted.length) - 1)] ?? 0,
  };
}

// A line for each step of the range.
export function rangeTable(
  series: Series,
  speed: readonly number[],
  from: number,
  to: number,
): { readonly header: string[]; readonly rows: number[][] } {
  const tissues = Object.entries(series.removed_by_tissue);
  const rows: number[][] = [];
  for (let i = from; i <= Math.min(to, series.t_s.length - 1); ++i) {
    rows.push([
      series.t_s[i]!,
      series.force_n[i]!,
      series.force_mean_n[i]!,
      series.bound_n[i]!,
      speed[i]!,
      series.removed_mm3[i]!,
      ...tissues.map(([, values]) => values[i] ?? Number.NaN),
      ...series.anchor_mm[i]!,
    ]);
  }
  return {
    header: [
      "time_s",
      "force_largest_N",
      "force_mean_N",
      "force_limit_N",
      "speed_mm_s",
      "removed_mm3",
      ...tissues.map(([tissue]) => `removed_${tissue}_mm3`),
      "x_mm",
      "y_mm",
      "z_mm",
    ],
    rows,
  };
}
