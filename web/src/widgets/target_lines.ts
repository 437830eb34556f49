import type { Exercise } from "../api/types";
import type { Body, PointMm, ToothLines } from "../tooth/messages";
import { isInside, outside, type Point2 } from "./outline_union";

// What the exercise asks for, in the scene's frame: as lines, of each part the opening and the
// floor, joined at the corners, and how far beside it may be cut (the leeway); and as a body, for
// the outline of a section.

type Target = Exercise["target"];
type Part = Target["parts"][number];

const kDiscPoints = 48,
  kDiscJoins = 4,
  kMaxJoins = 4, // of a polygon: more corners are arcs'
  kReliefSteps = 16; // along a side of a face that is not level
const kMaxCorners = 0x10000; // of a body

// A face of a part: its corners, counter-clockwise seen from above, and how high it lies.
interface Face {
  readonly corners: readonly Point2[];
  readonly zUm: (x: number, y: number) => number;
  readonly steps: number; // a side is drawn in so many
}

// Undefined: the server does not say where the target hangs.
export function linesOfTarget(target: Target): ToothLines | undefined {
  const at = target.landmark_um;
  if (at === undefined || at === null) return undefined;
  const out: { solid: PointMm[][]; faint: PointMm[][] } = { solid: [], faint: [] };
  for (const part of partsOf(target)) addPart(part, at, target, out);
  return out;
}

// From above: the outline of a hollow, and those that hide what of it lies within them, because they are as deep. In the
// scene's x and y, from the landmark.
interface Hollow {
  readonly part: Part;
  readonly corners: readonly Point2[];
  readonly hiddenBy: readonly (readonly Point2[])[];
}
function hollowsOf(target: Target): readonly Hollow[] {
  const bottom = (part: Part) => part.top_um[2]! - part.depth_um;
  const parts = target.parts.filter((part) => part.outline !== "stump");
  const outline = (part: Part) => cornersOf(part).map((corner) => shifted(corner, part.top_um));
  return parts.map((part) => ({
    part,
    corners: outline(part),
    hiddenBy: parts.filter((one) => one !== part && bottom(one) <= bottom(part)).map(outline),
  }));
}

function cornersOf(part: Part): readonly Point2[] {
  if (part.outline === "disc") {
    const radius = part.radius_um ?? 0;
    return Array.from(
      { length: kDiscPoints },
      (_, i): Point2 => [
        radius * Math.cos((2 * Math.PI * i) / kDiscPoints),
        radius * Math.sin((2 * Math.PI * i) / kDiscPoints),
      ],
    );
  }
  if (part.outline === "polygon") return (part.corners_um ?? []) as unknown as readonly Point2[];
  return rectangle((part.half_size_um ?? [0, 0]) as unknown as Point2);
}

function rectangle([x, y]: Point2): readonly Point2[] {
  return [
    [x, y],
    [-x, y],
    [-x, -y],
    [x, -y],
  ];
}

function shifted([x, y]: Point2, by: readonly number[]): Point2 {
  return [x + by[0]!, y + by[1]!];
}

// The border of all parts from above, as a path of a drawing: without the lines that a part hides which is as deep.
// Undefined: there is one part, whose own outline it is.
export function borderOf(target: Target): string | undefined {
  const hollows = hollowsOf(target);
  if (hollows.length < 2) return undefined;
  const lines = hollows.flatMap(({ corners, hiddenBy }) => outside(corners, hiddenBy));
  return lines.map((line) => `M ${line.map(([x, y]) => `${Math.round(x)} ${Math.round(-y)}`).join(" L ")}`).join(" ");
}

function partsOf(target: Target): readonly Part[] {
  return target.parts.length > 0 ? target.parts : [boxOf(target)];
}
function boxOf({ half_size_um: [x = 0, y = 0], depth_um: depth }: Target): Part {
  return { outline: "box", top_um: [0, 0, 0], half_size_um: [x, y], depth_um: depth };
}

function addPart(
  part: Part,
  at: readonly number[],
  target: Target,
  out: { solid: PointMm[][]; faint: PointMm[][] },
): void {
  const faces = facesOf(part, at);
  if (faces === undefined) return;
  const [floor, top] = faces;
  if (part.outline === "stump") {
    out.solid.push(ringOf(floor), ringOf(top), ...joins(floor, top, 1, []));
    return;
  }
  const hidden = hollowsOf(target).find((hollow) => hollow.part === part)?.hiddenBy ?? [];
  const others = hidden.map((ring) => ring.map((corner) => shifted(corner, at)));
  const every = part.outline === "disc" ? kDiscPoints / kDiscJoins : Math.ceil(top.corners.length / kMaxJoins);
  out.solid.push(...bordersOf(top, others), ...bordersOf(floor, others));
  out.solid.push(...joins(top, floor, every, others));
  const corners = grown(floor.corners, target.leeway_side_um);
  const deeper = (x: number, y: number) => floor.zUm(x, y) - target.leeway_bottom_um;
  const around = others.map((other) => grown(other, target.leeway_side_um));
  out.faint.push(...bordersOf({ ...top, corners }, around), ...bordersOf({ ...floor, corners, zUm: deeper }, around));
}

// Of a hollow its floor and its opening; of a stump, which stays, its foot and its table. The lower one first.
function facesOf(part: Part, at: readonly number[]): readonly [Face, Face] | undefined {
  const middle: Point2 = [at[0]! + part.top_um[0]!, at[1]! + part.top_um[1]!];
  const topUm = at[2]! + part.top_um[2]!;
  const { relief } = part;
  const level = (corners: readonly Point2[], belowUm: number): Face => ({
    corners,
    zUm: () => topUm - belowUm,
    steps: 1,
  });
  // The tooth's own shape, where the part has it.
  const own = (corners: readonly Point2[], belowUm: number): Face =>
    relief === undefined
      ? level(corners, belowUm)
      : { corners, zUm: (x, y) => topUm - reliefUm(relief, x - middle[0], y - middle[1]), steps: kReliefSteps };
  if (part.outline !== "stump") {
    const corners = cornersOf(part).map((corner) => shifted(middle, corner));
    return [own(corners, part.depth_um), level(corners, 0)];
  }
  if (part.stump === undefined) return undefined;
  const { foot, table, table_below_um: below } = part.stump;
  const section = ({ half_um: half, middle_um: own }: typeof foot) =>
    rectangle(half as unknown as Point2).map((corner) => shifted(shifted(middle, own), corner));
  return [level(section(foot), part.depth_um), own(section(table), below)];
}

// Below the opening at a place from the part's middle: between the points of its grid, level beyond the outermost.
function reliefUm(
  { step_um: step, count, below_um: below }: NonNullable<Part["relief"]>,
  x: number,
  y: number,
): number {
  const [columns = 1, rows = 1] = count;
  const [column, acrossX] = cellOf(x / step, columns);
  const [row, acrossY] = cellOf(y / step, rows);
  const point = (i: number, k: number) => below[Math.min(k, rows - 1) * columns + Math.min(i, columns - 1)] ?? 0;
  const along = (k: number) => between(point(column, k), point(column + 1, k), acrossX);
  return between(along(row), along(row + 1), acrossY);
}
// The point before, and how far it is to the next; `from`: the middle point, in steps.
function cellOf(from: number, count: number): readonly [number, number] {
  const place = Math.max(0, Math.min(count - 1, from + (count - 1) / 2));
  return [Math.floor(place), place - Math.floor(place)];
}
function between(a: number, b: number, share: number): number {
  return a + (b - a) * share;
}

// Sides and ends of each part. Undefined: there is none, or the server does not say where it is.
export function bodyOfTarget(target: Target): Body | undefined {
  const at = target.landmark_um;
  if (at === undefined || at === null) return undefined;
  const position: number[] = [];
  const triangle: number[] = [];
  for (const part of partsOf(target)) {
    const faces = facesOf(part, at);
    if (faces === undefined) continue;
    const [lower, upper] = faces;
    const steps = Math.max(lower.steps, upper.steps);
    addWall(ringOf({ ...lower, steps }), ringOf({ ...upper, steps }), position, triangle);
    addFace(lower, steps, false, position, triangle);
    addFace(upper, steps, true, position, triangle);
  }
  if (triangle.length === 0 || position.length / 3 > kMaxCorners) return undefined;
  return { positionMm: Float32Array.from(position), triangle: Uint16Array.from(triangle) };
}

function addWall(lower: readonly PointMm[], upper: readonly PointMm[], position: number[], triangle: number[]): void {
  const n = lower.length; // the last place of a ring is its first
  const first = position.length / 3;
  position.push(...lower.flat(), ...upper.flat());
  for (let i = first; i + 1 < first + n; ++i) triangle.push(i, i + 1, n + i + 1, i, n + i + 1, n + i);
}

// Each triangle of the outline in rows of smaller ones, whose corners meet those of the wall and of the next triangle.
function addFace(face: Face, steps: number, upward: boolean, position: number[], triangle: number[]): void {
  const flat = face.corners.map(([x, y]): PointMm => [x, y, 0]);
  for (const ear of trianglesIn(flat)) {
    const [a, b, c] = ear.map((i) => face.corners[i]!) as [Point2, Point2, Point2];
    const first = position.length / 3;
    const index = (row: number, i: number) => first + (row * (row + 1)) / 2 + i;
    for (let row = 0; row <= steps; ++row)
      for (let i = 0; i <= row; ++i) {
        const on = (axis: 0 | 1) => a[axis] + ((b[axis] - a[axis]) * (row - i) + (c[axis] - a[axis]) * i) / steps;
        position.push(...pointOn(face, [on(0), on(1)]));
      }
    const add = (p: number, q: number, r: number) => triangle.push(...(upward ? [p, q, r] : [p, r, q]));
    for (let row = 0; row < steps; ++row)
      for (let i = 0; i <= row; ++i) {
        add(index(row, i), index(row + 1, i), index(row + 1, i + 1));
        if (i < row) add(index(row, i), index(row + 1, i + 1), index(row, i + 1));
      }
  }
}

type Three = readonly [number, number, number];

// Of a counter-clockwise outline, which may have corners that point inwards: one ear after the other.
export function trianglesIn(outline: readonly PointMm[]): Three[] {
  const left = [...outline.keys()];
  const out: Three[] = [];
  const turn = (a: number, b: number, c: number) => {
    const [[ax, ay], [bx, by], [cx, cy]] = [outline[a]!, outline[b]!, outline[c]!];
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
  };
  const isEar = (i: number) => {
    const [a, b, c] = around(left, i);
    const inside = (p: number) =>
      p !== a && p !== b && p !== c && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
    return turn(a, b, c) > 0 && !left.some(inside);
  };
  while (left.length >= 3) {
    const ear = left.findIndex((_, i) => isEar(i));
    if (ear < 0) break; // what is left has no area
    out.push(around(left, ear));
    left.splice(ear, 1);
  }
  return out;
}
const around = (ring: readonly number[], i: number): Three => [ring.at(i - 1)!, ring[i]!, ring[(i + 1) % ring.length]!];

// Each side moved out by so much; corners lie where the moved sides meet. Counter-clockwise.
export function grown(corners: readonly Point2[], byUm: number): readonly Point2[] {
  return corners.map((corner, i): Point2 => {
    const [before, after] = [corners.at(i - 1)!, corners[(i + 1) % corners.length]!];
    const [ax, ay] = outward(before, corner);
    const [bx, by] = outward(corner, after);
    const together = 1 + ax * bx + ay * by; // twice the square of the cosine of half the angle between them
    return [corner[0] + (byUm * (ax + bx)) / together, corner[1] + (byUm * (ay + by)) / together];
  });
}

function outward([x0, y0]: Point2, [x1, y1]: Point2): Point2 {
  const length = Math.hypot(x1 - x0, y1 - y0) || 1;
  return [(y1 - y0) / length, (x0 - x1) / length];
}

function pointOn(face: Face, [x, y]: Point2): PointMm {
  return [x / 1000, y / 1000, face.zUm(x, y) / 1000];
}

// Closed: it ends where it begins.
function ringOf(face: Face): PointMm[] {
  const { corners, steps } = face;
  const sides = corners.flatMap(([x, y], i) => {
    const [nextX, nextY] = corners[(i + 1) % corners.length]!;
    return Array.from(
      { length: steps },
      (_, k): Point2 => [x + ((nextX - x) * k) / steps, y + ((nextY - y) * k) / steps],
    );
  });
  return [...sides, ...sides.slice(0, 1)].map((point) => pointOn(face, point));
}

// What of a ring the other parts do not hide.
function bordersOf(face: Face, others: readonly (readonly Point2[])[]): PointMm[][] {
  if (others.length === 0) return [ringOf(face)];
  return outside(face.corners, others).map((line) => line.map((point) => pointOn(face, point)));
}

function joins(one: Face, other: Face, every: number, others: readonly (readonly Point2[])[]): PointMm[][] {
  return one.corners.flatMap((corner, i) =>
    i % every === 0 && !others.some((ring) => isInside(corner, ring))
      ? [[pointOn(one, corner), pointOn(other, other.corners[i]!)]]
      : [],
  );
}
