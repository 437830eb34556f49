// Figures of agreement and of a pass mark, written down a second time from their formulas (schemas/marks.md), to check those
// of the server. Rows are pieces of work, columns markers.
const sum = (values) => values.reduce((total, value) => total + value, 0);
const mean = (values) => sum(values) / values.length;

// Two-way analysis of variance without repetition: Shrout and Fleiss, Psychological Bulletin 86 (1979) 420.
function meanSquares(rows) {
  const [n, k] = [rows.length, rows[0].length];
  const all = mean(rows.flat());
  const ofRows = rows.map(mean);
  const ofColumns = rows[0].map((_, j) => mean(rows.map((row) => row[j])));
  const total = sum(rows.flat().map((value) => (value - all) ** 2));
  const between = k * sum(ofRows.map((value) => (value - all) ** 2));
  const columns = n * sum(ofColumns.map((value) => (value - all) ** 2));
  const rest = (total - between - columns) / ((n - 1) * (k - 1));
  return { n, k, all, between: between / (n - 1), columns: columns / (k - 1), rest };
}

export function icc21(rows) {
  const { n, k, between, columns, rest } = meanSquares(rows);
  return (between - rest) / (between + (k - 1) * rest + (k * (columns - rest)) / n);
}

// Of the markers' mean: McGraw and Wong, Psychological Methods 1 (1996) 30, ICC(A,k).
export function phi(rows) {
  const { n, between, columns, rest } = meanSquares(rows);
  return (between - rest) / (between + (columns - rest) / n);
}

// Of the markers' mean at a cut score: Brennan and Kane, Journal of Educational Measurement 14 (1977) 277, in the form that has
// only moments of the marks; Φ where that is larger.
export function phiAt(rows, cut) {
  const k = rows[0].length;
  const all = mean(rows.flat());
  const within = mean(rows.flatMap((row) => row.map((value) => (value - mean(row)) ** 2)));
  const spread = mean(rows.map((row) => (mean(row) - all) ** 2));
  return Math.max(phi(rows), 1 - within / ((k - 1) * (spread + (all - cut) ** 2)));
}

// Cohen, Psychological Bulletin 70 (1968) 213, with squared distances: 1 less the share of disagreement found over that by chance.
export function weightedKappa(pairs) {
  const found = mean(pairs.map(([a, b]) => (a - b) ** 2));
  const chance = mean(pairs.flatMap(([a]) => pairs.map(([, b]) => (a - b) ** 2)));
  return 1 - found / chance;
}

const kBorderline = 2;
function cutOf(works) {
  const points = works.flatMap((work) => work.ratings.map((rating) => [rating, work.points]));
  const [x, y] = [mean(points.map(([rating]) => rating)), mean(points.map(([, value]) => value))];
  const slope = sum(points.map(([rating, value]) => (rating - x) * (value - y))) / sum(points.map(([rating]) => (rating - x) ** 2));
  return y + slope * (kBorderline - x);
}

// Points on ratings by least squares, at "borderline"; the interval from 4000 other draws of the same work than the server's.
export function borderline(works) {
  let state = 12345;
  const draw = () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0; // Numerical Recipes, 2nd ed., p. 284
    return works[Math.floor((state / 2 ** 32) * works.length)];
  };
  const cuts = Array.from({ length: 4000 }, () => cutOf(works.map(draw)))
    .filter(Number.isFinite)
    .sort((a, b) => a - b);
  const at = (share) => cuts[Math.min(cuts.length - 1, Math.max(0, Math.round(share * (cuts.length - 1))))];
  // Where the server's own quantile of 2000 draws may be: four standard errors of a share, sqrt(p (1 - p) / n), of
  // its draws and of these.
  const noise = 4 * Math.sqrt(0.025 * 0.975 * (1 / 2000 + 1 / cuts.length));
  const about = (share) => [at(share - noise), at(share + noise)];
  return { value: cutOf(works), low: about(0.025), high: about(0.975) };
}
