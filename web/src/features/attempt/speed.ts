import type { Series } from "../../api/types";

// The tip's speed in each step, mm/s, from where it was a step before; 0 in the first.
export function speeds({ t_s, anchor_mm }: Pick<Series, "t_s" | "anchor_mm">): number[] {
  return t_s.map((t, i) => {
    const [before, now] = [anchor_mm[i - 1], anchor_mm[i]];
    const dt = t - (t_s[i - 1] ?? t);
    if (before === undefined || now === undefined || dt <= 0) return 0;
    return Math.hypot(...[0, 1, 2].map((axis) => (now[axis] ?? 0) - (before[axis] ?? 0))) / dt;
  });
}
