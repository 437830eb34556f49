import { formatDuration } from "../../base/format";
import { flagTexts, type Track } from "./track";

// How far an attempt that is being made has come in time, and what went wrong in it lately.

export interface LiveTime {
  readonly text: string;
  readonly share: number | undefined;           // of the time limit; undefined: there is none
  readonly over: boolean;
}

// `ticks`: as many as the server has or the picture shows, whichever is more.
export function liveTime(ticks: number, rateHz: number, limitS: number): LiveTime {
  const spent = rateHz > 0 ? ticks / rateHz : 0;
  if (limitS === 0) return { text: `${formatDuration(Math.floor(spent))}, no time limit`, share: undefined, over: false };
  const left = limitS - spent;
  return left > 0 ? { text: `${formatDuration(Math.ceil(left))} left of ${formatDuration(limitS)}`, share: spent / limitS, over: false }
    : { text: `${formatDuration(Math.floor(-left))} over ${formatDuration(limitS)}`, share: 1, over: true };
}

// What the force was limited or stopped by in the seconds that are shown, each once, the newest first.
export function recentFaults(track: Track): string[] {
  return [...new Set([...track.rows].reverse().flatMap((row) => flagTexts(row.flags)))];
}
