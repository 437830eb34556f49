import type { Series, Ticks } from "../../api/types";
import type { View } from "./view";

// Where the plot shows only a few seconds, the recording's own ticks replace the series' steps.

const kMaxTicks = 4000; // that the server gives at once
const kBlockTicks = 1000; // who moves the part a little needs nothing new

// The ticks to ask for, for a part of the time; undefined: the series says as much, or they are too
// many.
export function ticksFor(series: Series, view: View | undefined): readonly [number, number] | undefined {
  if (view === undefined || series.step_ticks < 2) return undefined;
  const first = Math.max(0, Math.floor(view[0] * series.rate_hz));
  const from = first - (first % kBlockTicks);
  return view[1] * series.rate_hz > from + kMaxTicks ? undefined : [from, from + kMaxTicks];
}

export interface CloseUp {
  readonly timeS: readonly number[];
  readonly forceN: readonly (number | null)[];
  readonly computedN: readonly (number | null)[] | undefined; // undefined: nothing was held back
  readonly removedMm3: readonly number[]; // between the series' steps along a straight line
}

const kGapTicks = 1; // from tick to tick

// Columns to draw. A gap of the recording is a gap of the line.
export function closeUp(ticks: Ticks, series: Series): CloseUp {
  const timeS: number[] = [];
  const forceN: (number | null)[] = [];
  const computedN: (number | null)[] = [];
  let before = -1;
  let held = false;
  ticks.time_ticks.forEach((time, i) => {
    if (i > 0 && time > before + kGapTicks) {
      timeS.push((before + kGapTicks) / series.rate_hz);
      forceN.push(null);
      computedN.push(null);
    }
    before = time;
    timeS.push(time / series.rate_hz);
    forceN.push(ticks.force_n[i]!);
    computedN.push(ticks.computed_n[i]!);
    held ||= ticks.limited[i] === 1;
  });
  return { timeS, forceN, computedN: held ? computedN : undefined, removedMm3: between(series, timeS) };
}

function between({ t_s: steps, removed_mm3: removed }: Series, timeS: readonly number[]): number[] {
  let step = 0;
  return timeS.map((time) => {
    while (step + 1 < steps.length && steps[step + 1]! <= time) ++step;
    const [t0, t1] = [steps[step] ?? 0, steps[step + 1]];
    if (t1 === undefined) return removed[step] ?? 0;
    return removed[step]! + (removed[step + 1]! - removed[step]!) * Math.min(1, Math.max(0, (time - t0) / (t1 - t0)));
  });
}
