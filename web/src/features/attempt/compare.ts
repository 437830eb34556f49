import type { Series } from "../../api/types";
import { seriesEndS, stepAt } from "./clock";

// How the moment of one attempt is found in another.
export type Sync = "time" | "removed";

// The moment of `other` that belongs to `timeS` of `own`: the same time, or the first at which as much was removed. An attempt
// that has ended, or never removes as much, is at its end.
export function momentInOther(sync: Sync, own: Series, other: Series, timeS: number): number {
  const endS = seriesEndS(other);
  if (sync === "time") return Math.min(timeS, endS);
  if (timeS >= seriesEndS(own)) return endS;
  const removed = own.removed_mm3[stepAt(own, timeS)] ?? 0;
  let low = 0;
  let high = other.removed_mm3.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (other.removed_mm3[middle]! < removed) low = middle + 1;
    else high = middle;
  }
  return other.t_s[low] ?? endS;
}
