import type { Series } from "../../api/types";
import { say } from "../../base/words";

// What happened in a part of an attempt, in figures. Steps are equally long, so each counts the same.

export interface RangeRow {
  readonly title: string;
  readonly unit: string;
  readonly mean: number;
  readonly peak: number;
  readonly rms: number;                         // root of the mean square
  readonly p95: number;                         // the least value that 95 % of the steps do not exceed
}

// The tip's speed in each step, mm/s, from where it was a step before; 0 in the first.
export function speeds({ t_s, anchor_mm }: Pick<Series, "t_s" | "anchor_mm">): number[] {
  return t_s.map((t, i) => {
    const [before, now] = [anchor_mm[i - 1], anchor_mm[i]];
    const dt = t - (t_s[i - 1] ?? t);
    if (before === undefined || now === undefined || dt <= 0) return 0;
    return Math.hypot(...[0, 1, 2].map((axis) => (now[axis] ?? 0) - (before[axis] ?? 0))) / dt;
  });
}

// Of steps `from` to `to`, both counted.
export function rangeRows(series: Series, from: number, to: number): RangeRow[] {
  const part = (values: readonly number[]) => values.slice(from, to + 1);
  return [row(say("plot.largest_force"), "N", part(series.force_n)), row(say("plot.mean_force"), "N", part(series.force_mean_n)), row(say("plot.tip_speed"), "mm/s", part(speeds(series)))];
}

// mm³ that went in the steps, in all and by tissue.
export function removedIn(series: Series, from: number, to: number): readonly (readonly [string, number])[] {
  const gone = (values: readonly number[]) => (values[to] ?? 0) - (from === 0 ? 0 : values[from - 1] ?? 0);
  return [["all", gone(series.removed_mm3)], ...Object.entries(series.removed_by_tissue).map(([tissue, values]) => [tissue, gone(values)] as const)];
}

function row(title: string, unit: string, values: readonly number[]): RangeRow {
  const n = Math.max(1, values.length);
  const sorted = [...values].sort((a, b) => a - b);
  return {
    title, unit, mean: values.reduce((sum, value) => sum + value, 0) / n, peak: sorted.at(-1) ?? 0,
    rms: Math.sqrt(values.reduce((sum, value) => sum + value * value, 0) / n), p95: sorted[Math.max(0, Math.ceil(0.95 * sorted.length) - 1)] ?? 0,
  };
}

// A line for each step of the range.
export function rangeTable(series: Series, from: number, to: number): { readonly header: string[]; readonly rows: number[][] } {
  const tissues = Object.entries(series.removed_by_tissue);
  const speed = speeds(series);
  const rows: number[][] = [];
  for (let i = from; i <= Math.min(to, series.t_s.length - 1); ++i) {
    rows.push([series.t_s[i]!, series.force_n[i]!, series.force_mean_n[i]!, series.bound_n[i]!, speed[i]!, series.removed_mm3[i]!, ...tissues.map(([, values]) => values[i] ?? Number.NaN), ...series.anchor_mm[i]!]);
  }
  return { header: ["time_s", "force_largest_N", "force_mean_N", "force_limit_N", "speed_mm_s", "removed_mm3", ...tissues.map(([tissue]) => `removed_${tissue}_mm3`), "x_mm", "y_mm", "z_mm"], rows };
}
