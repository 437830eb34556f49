import type { Mistake } from "./types";

// Points of a hundred. A mistake that cost less is not shown at first, and no advice is given for it.
export const kWorthAdvice = 0.5;

export function isWorthAdvice({ points }: Pick<Mistake, "points">): boolean {
  return points >= kWorthAdvice;
}
