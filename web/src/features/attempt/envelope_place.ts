import { say } from "../../base/words";

interface Place {
  readonly value: number;
  readonly least: number;
  readonly most: number;
}

// Where a value lies among the dentists'. Neither side is said to be better: of some criteria less
// is, of others more.
export function placeAmong({ value, least, most }: Place): string {
  if (value < least) return say("envelope.below");
  return value > most ? say("envelope.above") : say("envelope.among");
}

export function isAmong({ value, least, most }: Place): boolean {
  return value >= least && value <= most;
}
