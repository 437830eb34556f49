import type { Series } from "../../api/types";

// Which moment of another attempt belongs to one of this by where the bur was, whatever the pace.
//
// Dynamic time warping of the two paths of the tip, distances in mm:
//   D(i, j) = |a_i − b_j| + min(D(i−1, j−1), D(i−1, j), D(i, j−1))
// The result is the pairs (i, j) of the cheapest path from the first pair to the last; of equally
// cheap ones the diagonal. (Sakoe and Chiba, "Dynamic programming algorithm optimization for spoken
// word recognition", IEEE Trans. ASSP 26(1), 1978; the same steps and weights as
// common/scoring/align.h.) There is no band: a late start may be any distance from the diagonal.

export type PathMatch = (timeS: number) => number;

// Of clock.ts, whose import would make a script of its own of what the page loads at once.
const seriesEndS = (series: Series): number => (series.t_s.at(-1) ?? 0) + series.step_ticks / series.rate_hz;

const kMaxSteps = 1000; // of each attempt; a byte for every pair of them

// Every n-th step, and the last one.
export function thinned(steps: number, most = kMaxSteps): number[] {
  const every = Math.max(1, Math.ceil((steps - 1) / (most - 1)));
  const taken = Array.from({ length: Math.ceil(Math.max(0, steps - 1) / every) }, (_, i) => i * every);
  return steps === 0 ? [] : [...taken, steps - 1];
}

function pointsOf(series: Series, steps: readonly number[]): Float64Array {
  const out = new Float64Array(3 * steps.length);
  for (const [i, step] of steps.entries()) out.set(series.anchor_mm[step] ?? [0, 0, 0], 3 * i);
  return out;
}

const kBoth = 0,
  kFirst = 1,
  kSecond = 2; // which of the two has gone on by a step

interface Pair {
  readonly i: number;
  readonly j: number;
  readonly mm: number;
}

// Both have a point at least.
function cheapestWay(a: Float64Array, b: Float64Array): Pair[] {
  const [n, m] = [a.length / 3, b.length / 3];
  const apart = (i: number, j: number) => {
    const [x, y, z] = [a[3 * i]! - b[3 * j]!, a[3 * i + 1]! - b[3 * j + 1]!, a[3 * i + 2]! - b[3 * j + 2]!];
    return Math.sqrt(x * x + y * y + z * z); // Math.hypot is several times as slow
  };
  const came = new Uint8Array(n * m);
  const cost = new Float64Array(m).fill(Infinity);
  for (let i = 0; i < n; ++i) {
    let diagonal = i === 0 ? 0 : Infinity; // D(i−1, j−1)
    let left = Infinity; // D(i, j−1)
    for (let j = 0; j < m; ++j) {
      const above = cost[j]!; // D(i−1, j)
      let least = diagonal;
      let from = kBoth;
      if (above < least) {
        least = above;
        from = kFirst;
      }
      if (left < least) {
        least = left;
        from = kSecond;
      }
      came[i * m + j] = from;
      left = cost[j] = least + apart(i, j);
      diagonal = above;
    }
  }
  const way: Pair[] = [];
  for (let i = n - 1, j = m - 1; i >= 0 && j >= 0; ) {
    way.push({ i, j, mm: apart(i, j) });
    const from = came[i * m + j];
    if (from !== kSecond) --i;
    if (from !== kFirst) --j;
  }
  return way.reverse();
}

// The pairs of which neither has a nearer partner on the way: where one goes slower, the others lie
// between two of these.
function mutual(way: readonly Pair[], n: number, m: number): Pair[] {
  const [ofFirst, ofSecond] = [new Float64Array(n).fill(Infinity), new Float64Array(m).fill(Infinity)];
  for (const { i, j, mm } of way) {
    ofFirst[i] = Math.min(ofFirst[i]!, mm);
    ofSecond[j] = Math.min(ofSecond[j]!, mm);
  }
  return way.filter(
    ({ i, j, mm }, at) => at === 0 || at === way.length - 1 || (mm <= ofFirst[i]! && mm <= ofSecond[j]!),
  );
}

// Of two attempts: the other's moment for each of this one's. It never goes back. At the end of one
// it is the end of the other; where one of them has no steps, the same time.
export function matchPaths(own: Series, other: Series): PathMatch {
  const [ends, otherEnds] = [seriesEndS(own), seriesEndS(other)];
  if (own.t_s.length === 0 || other.t_s.length === 0) return (timeS) => Math.min(timeS, otherEnds);
  const [steps, others] = [thinned(own.t_s.length), thinned(other.t_s.length)];
  const pairs = mutual(cheapestWay(pointsOf(own, steps), pointsOf(other, others)), steps.length, others.length);
  const times = Float64Array.from([...pairs.map(({ i }) => own.t_s[steps[i]!]!), ends]);
  const theirs = Float64Array.from([...pairs.map(({ j }) => other.t_s[others[j]!]!), otherEnds]);
  return (timeS) => {
    if (timeS >= ends) return otherEnds;
    let low = 0; // the first that is not before
    let high = times.length - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle]! < timeS) low = middle + 1;
      else high = middle;
    }
    if (low === 0) return theirs[0]!;
    const share = (timeS - times[low - 1]!) / (times[low]! - times[low - 1]!);
    return theirs[low - 1]! + share * (theirs[low]! - theirs[low - 1]!);
  };
}

const known = new WeakMap<Series, WeakMap<Series, PathMatch>>();

// The same, worked out once for two attempts.
export function pathMatch(own: Series, other: Series): PathMatch {
  const ofOwn = known.get(own) ?? new WeakMap<Series, PathMatch>();
  known.set(own, ofOwn);
  const match = ofOwn.get(other) ?? matchPaths(own, other);
  ofOwn.set(other, match);
  return match;
}
