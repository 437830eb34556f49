import { formatQuantity } from "../../base/format";
import { say } from "../../base/words";

interface Place {
  readonly value: number;
  readonly least: number;
  readonly most: number;
  readonly unit: string;
}

// Where a value lies among the dentists'. Neither side is said to be better: of some criteria less
// is, of others more.
export function placeAmong(place: Place): string {
  if (isAmong(place)) return say("envelope.among");
  return place.value < place.least ? say("envelope.below") : say("envelope.above");
}

// Also where it is beyond an edge by less than the digits that are shown: nobody sees a difference there.
export function isAmong({ value, least, most, unit }: Place): boolean {
  const shown = formatQuantity(value, unit);
  return (value >= least && value <= most) || [least, most].some((edge) => formatQuantity(edge, unit) === shown);
}
