// The border of a union of outlines: of each ring the lines that lie outside the others. Rings go round
// counter-clockwise and are closed: the last point joins the first. Any unit; `kNear` in the same as the points, um.

export type Point2 = readonly [number, number];

const kNear = 5; // a line along another ring's border is not inside it

// `others`: those that hide what of the ring lies within them.
export function outside(ring: readonly Point2[], others: readonly (readonly Point2[])[]): readonly Point2[][] {
  const out: Point2[][] = [];
  for (const [i, from] of ring.entries()) {
    const to = ring[(i + 1) % ring.length]!;
    const cuts = others.flatMap((other) => crossings(from, to, other));
    const shares = [0, ...cuts.sort((a, b) => a - b), 1];
    for (const [k, share] of shares.slice(0, -1).entries()) {
      const next = shares[k + 1]!;
      if (next - share < 1e-9 || others.some((other) => isInside(along(from, to, (share + next) / 2), other))) continue;
      const [start, end] = [along(from, to, share), along(from, to, next)];
      const last = out.at(-1);
      if (last !== undefined && isAt(last.at(-1)!, start)) last.push(end);
      else out.push([start, end]);
    }
  }
  // The last line may go on in the first one.
  const [first, last] = [out[0], out.at(-1)];
  if (first !== undefined && last !== undefined && first !== last && isAt(last.at(-1)!, first[0]!)) {
    out[0] = [...last, ...first.slice(1)];
    out.pop();
  }
  return out;
}

export function isInside(point: Point2, ring: readonly Point2[]): boolean {
  let inside = false;
  for (const [i, a] of ring.entries()) {
    const b = ring[(i + 1) % ring.length]!;
    if (distanceTo(point, a, b) < kNear) return false;
    if (a[1] > point[1] === b[1] > point[1]) continue;
    if (point[0] < a[0] + ((b[0] - a[0]) * (point[1] - a[1])) / (b[1] - a[1])) inside = !inside;
  }
  return inside;
}

// Where the line meets the ring, as shares of its way.
function crossings(from: Point2, to: Point2, ring: readonly Point2[]): number[] {
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  return ring.flatMap((a, i) => {
    const b = ring[(i + 1) % ring.length]!;
    const [ex, ey] = [b[0] - a[0], b[1] - a[1]];
    const cross = dx * ey - dy * ex;
    if (cross === 0) return [];
    const [ax, ay] = [a[0] - from[0], a[1] - from[1]];
    const [share, other] = [(ax * ey - ay * ex) / cross, (ax * dy - ay * dx) / cross];
    return share > 0 && share < 1 && other >= 0 && other <= 1 ? [share] : [];
  });
}

function distanceTo([x, y]: Point2, a: Point2, b: Point2): number {
  const [ex, ey] = [b[0] - a[0], b[1] - a[1]];
  const length = ex * ex + ey * ey;
  const share = length > 0 ? Math.max(0, Math.min(1, ((x - a[0]) * ex + (y - a[1]) * ey) / length)) : 0;
  return Math.hypot(x - a[0] - share * ex, y - a[1] - share * ey);
}

function along(from: Point2, to: Point2, share: number): Point2 {
  return [from[0] + (to[0] - from[0]) * share, from[1] + (to[1] - from[1]) * share];
}
function isAt(a: Point2, b: Point2): boolean {
  return a[0] === b[0] && a[1] === b[1];
}
