import { formatDuration } from "../../base/format";
import { say } from "../../base/words";
import { flagTexts, type Track } from "./track";

// How far an attempt that is being made has come in time, and what went wrong in it lately.

export interface LiveTime {
  readonly text: string;
  readonly share: number | undefined; // of the time limit; undefined: there is none
  readonly over: boolean;
}

// `ticks`: as many as the server has or the picture shows, whichever is more.
export function liveTime(ticks: number, rateHz: number, limitS: number): LiveTime {
  const spent = rateHz > 0 ? ticks / rateHz : 0;
  if (limitS === 0)
    return { text: say("live.no_limit", { spent: formatDuration(Math.floor(spent)) }), share: undefined, over: false };
  const left = limitS - spent;
  return left > 0
    ? {
        text: say("live.left", { left: formatDuration(Math.ceil(left)), limit: formatDuration(limitS) }),
        share: spent / limitS,
        over: false,
      }
    : {
        text: say("live.over", { over: formatDuration(Math.floor(-left)), limit: formatDuration(limitS) }),
        share: 1,
        over: true,
      };
}

// What the force was limited or stopped by in the seconds that are shown, each once, the newest
// first.
export function recentFaults(track: Track): string[] {
  return [...new Set([...track.rows].reverse().flatMap((row) => flagTexts(row.flags)))];
}
