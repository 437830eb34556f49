import { forceSize, type LiveRow } from "../../api/live";
import { say } from "../../base/words";

// What the page remembers of an attempt that it watches: the last seconds, bounded.
export interface Track {
  readonly rows: readonly LiveRow[];
  readonly state: "waiting" | "live" | "ended" | "disturbed";
  readonly problem: string;
  readonly heardMs: number; // when rows came last; 0: none yet
}

export const kTrackSeconds = 20;
export const kDefaultRateHz = 1000; // of exercises; only sets how long ago is drawn where
const kMaxRows = 2000; // 20 s at 60 rows a second, and room for faster stations

export const emptyTrack: Track = { rows: [], state: "waiting", problem: "", heardMs: 0 };

// Rows come in order; a station that restarts (ticks go back) begins a new track.
export function withRows(track: Track, rows: readonly LiveRow[], rateHz: number, nowMs: number): Track {
  const last = rows.at(-1);
  if (last === undefined) return track;
  const kept = (track.rows.at(-1)?.tick ?? -1) < (rows[0]?.tick ?? 0) ? track.rows : [];
  const oldest = last.tick - kTrackSeconds * rateHz;
  return {
    rows: [...kept, ...rows].filter((row) => row.tick >= oldest).slice(-kMaxRows),
    state: "live",
    problem: "",
    heardMs: nowMs,
  };
}

const kMinShownSeconds = 4;

// How many seconds a strip of the track shows: as much as was seen, so that it is filled from the
// beginning.
export function shownSeconds(rows: readonly LiveRow[], rateHz: number): number {
  const seen = ((rows.at(-1)?.tick ?? 0) - (rows[0]?.tick ?? 0)) / rateHz;
  return Math.min(Math.max(seen, kMinShownSeconds), kTrackSeconds);
}

export interface Extent {
  readonly low: readonly [number, number, number];
  readonly high: readonly [number, number, number];
}

export function extentOf(rows: readonly LiveRow[]): Extent | undefined {
  const first = rows[0];
  if (first === undefined) return undefined;
  const low: [number, number, number] = [...first.anchorMm];
  const high: [number, number, number] = [...first.anchorMm];
  for (const { anchorMm } of rows) {
    for (let axis = 0; axis < 3; ++axis) {
      low[axis] = Math.min(low[axis]!, anchorMm[axis]!);
      high[axis] = Math.max(high[axis]!, anchorMm[axis]!);
    }
  }
  return { low, high };
}

export function largestForce(rows: readonly LiveRow[]): number {
  return rows.reduce((largest, row) => Math.max(largest, forceSize(row)), 0);
}

const kFlags: ReadonlyArray<
  readonly [number, "guarded" | "peak" | "reset" | "reserve" | "suspended" | "fault" | "swing"]
> = [
  [1, "guarded"],
  [2, "peak"],
  [256, "reset"],
  [512, "reserve"],
  [1024, "suspended"],
  [2048, "fault"],
  [4096, "swing"],
];

// What of a tick's witness flags (schemas/trace_format.md, column 19) a teacher wants to know.
export function flagTexts(flags: number): string[] {
  return kFlags.filter(([bit]) => (flags & bit) !== 0).map(([, name]) => say(`track.${name}`));
}
