import type { Series } from "../../api/types";
import type { Head } from "../../tooth/timeline";

// Times of an attempt, in seconds since its first tick, gaps included: what the series, the
// playback and a link share.

// Where ticks passed that were not recorded.
export interface Gap {
  readonly frames: number; // it ends where so many frames end
  readonly seconds: number;
  readonly endS: number;
}

// When each frame of a playback ends. Of a segment that is not here yet no gap is known.
export class FrameClock {
  readonly gaps: readonly Gap[];
  private readonly gapTicks: Float64Array; // before the end of so many frames

  constructor(
    private readonly head: Head,
    segments: readonly (Uint32Array | undefined)[], // of each frame, the ticks of its gaps
  ) {
    this.gapTicks = new Float64Array(head.frames + 1);
    const gaps: Gap[] = [];
    for (let k = 0; k < head.frames; ++k) {
      const ticks = segments[Math.floor(k / head.segmentFrames)]?.[k % head.segmentFrames] ?? 0;
      this.gapTicks[k + 1] = this.gapTicks[k]! + ticks;
      if (ticks > 0) gaps.push({ frames: k + 1, seconds: ticks / head.rateHz, endS: this.timeOf(k + 1) });
    }
    this.gaps = gaps;
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

// The step of the series that contains a time.
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
