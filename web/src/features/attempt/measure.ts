import { formatQuantity } from "../../base/format";
import { say } from "../../base/words";
import type { PointMm, ToothLines } from "../../tooth/messages";

// Distances between points that somebody puts on a tooth, and the angle at the second of three.

const kNames = ["a", "b", "c"] as const;

export const nameOfPoint = (index: number): string => kNames[index] ?? "";

// A fourth point begins anew.
export function withPoint(points: readonly PointMm[], point: PointMm): readonly PointMm[] {
  return points.length === kNames.length ? [point] : [...points, point];
}

const between = (a: PointMm, b: PointMm): PointMm => [b[0] - a[0], b[1] - a[1], b[2] - a[2]];

export function distanceMm(a: PointMm, b: PointMm): number {
  return Math.hypot(...between(a, b));
}

// At `b`, 0 to 180. Undefined: two of the points are one.
export function angleDeg(a: PointMm, b: PointMm, c: PointMm): number | undefined {
  const [u, v] = [between(b, a), between(b, c)];
  const [x, y] = [Math.hypot(...u), Math.hypot(...v)];
  if (x === 0 || y === 0) return undefined;
  const cosine = (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) / (x * y);
  return (Math.acos(Math.min(1, Math.max(-1, cosine))) * 180) / Math.PI;
}

export function measuredLines(points: readonly PointMm[]): ToothLines {
  return { solid: [points], faint: [] };
}

export function joinedLines(one: ToothLines | undefined, other: ToothLines | undefined): ToothLines | undefined {
  if (one === undefined || other === undefined) return one ?? other;
  return { solid: [...one.solid, ...other.solid], faint: [...one.faint, ...other.faint] };
}

// In words, with what to do next.
export function measuredText(points: readonly PointMm[]): string {
  const [a, b, c] = points;
  if (a === undefined) return say("measure.first");
  if (b === undefined) return say("measure.second");
  const ab = formatQuantity(distanceMm(a, b), "mm");
  if (c === undefined) return say("measure.two", { ab });
  const angle = angleDeg(a, b, c);
  return say("measure.three", {
    ab,
    bc: formatQuantity(distanceMm(b, c), "mm"),
    angle: angle === undefined ? "–" : formatQuantity(angle, "deg"),
  });
}
