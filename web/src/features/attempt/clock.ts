import type { Series } from "../../api/types";
import type { FramePose, Head } from "../../api/timeline";

// Times of an attempt, in seconds since its first tick, gaps included: what the series, the playback and a link share.

// When each frame of a playback ends. Before its poses are here no gap is known.
export class FrameClock {
  private readonly gapTicks: Float64Array;      // before the end of so many frames

  constructor(private readonly head: Head, poses: readonly (FramePose | undefined)[]) {
    this.gapTicks = new Float64Array(head.frames + 1);
    for (let k = 0; k < head.frames; ++k) this.gapTicks[k + 1] = this.gapTicks[k]! + (poses[k]?.gapTicks ?? 0);
  }

  get endS(): number {
    return this.timeOf(this.head.frames);
  }
  timeOf(frames: number): number {
    const { frameTicks, rateHz, ticks } = this.head;
    return (Math.min(frames * frameTicks, ticks) + this.gapTicks[frames]!) / rateHz;
  }
  // So many frames that their end is nearest.
  framesAt(timeS: number): number {
    let low = 0;
    let high = this.head.frames;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.timeOf(middle) < timeS) low = middle + 1;
      else high = middle;
    }
    return low > 0 && timeS - this.timeOf(low - 1) < this.timeOf(low) - timeS ? low - 1 : low;
  }
}

export interface Gap {
  readonly frames: number;                      // it lies before the end of so many
  readonly seconds: number;
}

// Where ticks passed that were not recorded.
export function gapsOf(head: Head, poses: readonly (FramePose | undefined)[]): Gap[] {
  return poses.flatMap((pose, i) => pose === undefined || pose.gapTicks === 0 ? [] : [{ frames: i + 1, seconds: pose.gapTicks / head.rateHz }]);
}

// The step of the series that a time lies in.
export function stepAt(series: Series, timeS: number): number {
  return stepIn(series.t_s, timeS);
}

// The last of growing times that is no later.
export function stepIn(times: readonly number[], timeS: number): number {
  const last = times.length - 1;
  let low = 0;
  let high = Math.max(0, last);
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    // Times are written to a tenth of a millisecond.
    if (times[middle]! <= timeS + 1e-4) low = middle;
    else high = middle - 1;
  }
  return low;
}

// When the last step ends.
export function seriesEndS(series: Series): number {
  return (series.t_s.at(-1) ?? 0) + series.step_ticks / series.rate_hz;
}
