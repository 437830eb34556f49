import type { Series } from "../../api/types";
import { seriesEndS, stepAt } from "./clock";
import type { PathMatch } from "./path_sync";

// How the moment of one attempt is found in another.
export type Sync = "time" | "removed" | "path";

// Where another attempt is drawn: beside this one, or over it.
export type Placement = "side" | "top";

// The moment of `other` that belongs to `timeS` of `own`: the same time, the first at which as much
// was removed, or when the bur was at the same place on its way (`path`: how the two ways belong
// together; undefined while it is not known). An attempt that has ended, or never removes as much,
// is at its end. The end belongs to the end, so that two finished teeth are compared.
export function momentInOther(
  sync: Sync,
  own: Series,
  other: Series,
  timeS: number,
  path?: PathMatch,
): number | undefined {
  const endS = seriesEndS(other);
  if (timeS > (own.t_s.at(-1) ?? 0)) return endS; // in the last step
  if (sync === "path") return path?.(timeS);
  if (sync === "time") return Math.min(timeS, endS);
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
