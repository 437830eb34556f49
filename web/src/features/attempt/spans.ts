import type { Deduction, Series } from "../../api/types";
import type { Gap } from "./clock";

// What stands on the axis of time: parts of the attempt that are worth a look.

export type SpanKind = "contact" | "limit" | "late" | "gap" | "lost";

export interface Span {
  readonly kind: SpanKind;
  readonly fromS: number;
  readonly toS: number;
}

export const kContactN = 0.05; // mean force of a step in which the tool touches
const kAtLimit = 0.98; // of the device's limit: series are rounded

// Steps in which `holds`, joined.
function stretches(series: Series, kind: SpanKind, holds: (step: number) => boolean): Span[] {
  const out: Span[] = [];
  const stepS = series.step_ticks / series.rate_hz;
  for (let i = 0, from = -1; i <= series.t_s.length; ++i) {
    const on = i < series.t_s.length && holds(i);
    if (on && from < 0) from = i;
    if (on || from < 0) continue;
    out.push({ kind, fromS: series.t_s[from]!, toS: series.t_s[i - 1]! + stepS });
    from = -1;
  }
  return out;
}

// A stroke that took too much has a beginning only; what was left standing has no time.
export function spansOf(series: Series, gaps: readonly Gap[], deductions: readonly Deduction[]): Span[] {
  const lost = new Map<number, Span>();
  for (const { left, strokes } of deductions) {
    if (!left)
      for (const { first_tick, first_s } of strokes)
        lost.set(first_tick, { kind: "lost", fromS: first_s, toS: first_s });
  }
  return [
    ...stretches(series, "contact", (i) => series.force_mean_n[i]! >= kContactN),
    ...stretches(series, "limit", (i) => series.bound_n[i]! > 0 && series.force_n[i]! >= kAtLimit * series.bound_n[i]!),
    ...stretches(series, "late", (i) => (series.late_ticks[i] ?? 0) > 0),
    ...gaps.map(({ endS, seconds }): Span => ({ kind: "gap", fromS: endS - seconds, toS: endS })),
    ...lost.values(),
  ].sort((a, b) => a.fromS - b.fromS);
}

const kSameS = 0.05; // a moment is shown to a tenth

// The next moment, or the one before, at which a fault or a stroke that lost points begins. After
// the last comes the first: an attempt opens at its end. Undefined: there is none.
export function nextMark(spans: readonly Span[], timeS: number, direction: -1 | 1): number | undefined {
  const moments = spans.filter(({ kind }) => kind !== "contact").map(({ fromS }) => fromS);
  return direction > 0
    ? (moments.find((at) => at > timeS + kSameS) ?? moments[0])
    : (moments.filter((at) => at < timeS - kSameS).at(-1) ?? moments.at(-1));
}
