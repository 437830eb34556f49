import type { Annotation, Series } from "../../api/types";
import { stepAt } from "./clock";

// Moments of an attempt: ticks of the recording, steps of its series, seconds.

// The step of the series that contains `tick`; the last one for ticks beyond.
export function stepOfTick(series: Series, tick: number): number {
  return Math.max(0, Math.min(Math.floor(tick / series.step_ticks), series.t_s.length - 1));
}

export function tickOfStep(series: Series, step: number): number {
  return step * series.step_ticks;
}

// The tick of a moment; the end is the tick after the last one. Of a gap in a step, the end of that
// step.
export function tickAt(series: Series, timeS: number): number {
  const step = stepAt(series, timeS);
  const into = Math.round((timeS - (series.t_s[step] ?? 0)) * series.rate_hz);
  return tickOfStep(series, step) + Math.max(0, Math.min(into, series.step_ticks));
}

// When that was, gaps included.
export function secondsOfTick(series: Series, tick: number): number {
  const step = stepOfTick(series, tick);
  return (
    (series.t_s[step] ?? 0) + Math.max(0, Math.min(tick - tickOfStep(series, step), series.step_ticks)) / series.rate_hz
  );
}

const kNearBound = 1.05; // a limit farther from the largest force says nothing about it

// The device's limit as a line, null where it was not known yet: before the first force it is
// 0. Undefined where the force never came near it.
export function boundLine({
  bound_n: bound,
  force_n: force,
}: Pick<Series, "bound_n" | "force_n">): (number | null)[] | undefined {
  const largest = force.reduce((a, b) => Math.max(a, b), 0);
  return bound.some((value) => value > 0 && value <= largest * kNearBound)
    ? bound.map((value) => (value > 0 ? value : null))
    : undefined;
}

export interface Mark {
  readonly annotation: Annotation;
  readonly number: number; // as written beside it, from 1 in order of time
  readonly step: number;
  readonly share: number; // 0..1 along the timeline
}

// Remarks in order of their time.
export function marksOf(series: Series, annotations: readonly Annotation[]): Mark[] {
  const last = Math.max(1, series.t_s.length - 1);
  return [...annotations]
    .sort((a, b) => a.tick - b.tick || a.created_ms - b.created_ms)
    .map((annotation, i) => {
      const step = stepOfTick(series, annotation.tick);
      return { annotation, number: i + 1, step, share: step / last };
    });
}
