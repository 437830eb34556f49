import { fail, ok, type Result } from "../base/result";
import type { Series, Ticks } from "./types";

const kMaxSteps = 100_000;
const kColumns = ["t_s", "force_n", "force_mean_n", "computed_n", "late_ticks", "bound_n", "removed_mm3"] as const;
const kTickColumns = ["time_ticks", "force_n", "computed_n", "late", "limited"] as const;

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
  if (series.pulp_mm !== undefined && !isNumbers(series.pulp_mm, steps))
    return fail(`series column pulp_mm is not ${steps} finite numbers`);
  if (series.felt_error !== undefined && !Number.isFinite(series.felt_error))
    return fail("the series' felt_error is no finite number");
  for (let i = 1; i < steps; ++i) {
    if (series.t_s[i]! <= series.t_s[i - 1]!) return fail(`series time does not grow at step ${i}`);
  }
  if (!isPoints(series.anchor_mm, steps)) return fail(`series column anchor_mm is not ${steps} points`);
  if (!isPoints(series.force_vector_n, steps)) return fail(`series column force_vector_n is not ${steps} vectors`);
  const tissues: unknown = series.removed_by_tissue;
  if (
    typeof tissues !== "object" ||
    tissues === null ||
    !Object.values(tissues).every((column) => isNumbers(column, steps))
  ) {
    return fail(`series column removed_by_tissue is not ${steps} numbers for each tissue`);
  }
  return ok(series);
}

// The same of what the recording says of each tick.
export function checkTicks(value: unknown): Result<Ticks, string> {
  if (typeof value !== "object" || value === null) return fail("the answer is no object");
  const ticks = value as Ticks;
  const count = Array.isArray(ticks.time_ticks) ? ticks.time_ticks.length : -1;
  if (count < 0 || count > kMaxSteps) return fail(`the ticks have no usable time column (at most ${kMaxSteps})`);
  for (const name of kTickColumns) {
    if (!isNumbers(ticks[name], count)) return fail(`column ${name} is not ${count} finite numbers`);
  }
  return ticks.time_ticks.every((time, i) => i === 0 || time > ticks.time_ticks[i - 1]!)
    ? ok(ticks)
    : fail("the time of ticks does not grow");
}

function isPoints(value: unknown, length: number): boolean {
  return Array.isArray(value) && value.length === length && value.every((point) => isNumbers(point, 3));
}

function isNumbers(value: unknown, length: number): value is number[] {
  return Array.isArray(value) && value.length === length && value.every((item) => Number.isFinite(item));
}
