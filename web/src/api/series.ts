import { fail, ok, type Result } from "../base/result";
import type { Series } from "./types";

const kMaxSteps = 100_000;
const kColumns = ["t_s", "force_n", "force_mean_n", "bound_n", "removed_mm3"] as const;

// A plot walks these arrays side by side: they have one length, hold finite numbers, time grows.
// The error says what was found.
export function checkSeries(value: unknown): Result<Series, string> {
  if (typeof value !== "object" || value === null) return fail("the series is no object");
  const series = value as Series;
  const steps = Array.isArray(series.t_s) ? series.t_s.length : -1;
  if (steps < 0 || steps > kMaxSteps) return fail(`the series has no usable time column (at most ${kMaxSteps} steps)`);
  for (const name of kColumns) {
    const column: unknown = series[name];
    if (!isNumbers(column, steps)) return fail(`series column ${name} is not ${steps} finite numbers`);
  }
  for (let i = 1; i < steps; ++i) {
    if (series.t_s[i]! <= series.t_s[i - 1]!) return fail(`series time does not grow at step ${i}`);
  }
  const anchors: unknown = series.anchor_mm;
  if (!Array.isArray(anchors) || anchors.length !== steps || !anchors.every((point) => isNumbers(point, 3))) {
    return fail(`series column anchor_mm is not ${steps} points`);
  }
  const tissues: unknown = series.removed_by_tissue;
  if (typeof tissues !== "object" || tissues === null || !Object.values(tissues).every((column) => isNumbers(column, steps))) {
    return fail(`series column removed_by_tissue is not ${steps} numbers for each tissue`);
  }
  return ok(series);
}

function isNumbers(value: unknown, length: number): value is number[] {
  return Array.isArray(value) && value.length === length && value.every((item) => Number.isFinite(item));
}
