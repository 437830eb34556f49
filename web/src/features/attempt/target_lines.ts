import type { Exercise } from "../../api/types";
import type { Body, PointMm, ToothLines } from "../../tooth/messages";

// What the exercise asks for, in the scene's frame: as lines, of each part the opening and the
// floor, joined at the corners, and how far beside it may be cut (the leeway); and as a body, for
// the outline of a section.

type Target = Exercise["target"];
type Part = Target["parts"][number];
type Point2 = readonly [number, number];

const kDiscPoints = 48,
  kDiscJoins = 4;

// Undefined: the server does not say where the target hangs.
export function linesOfTarget(target: Target): ToothLines | undefined {
  const at = target.landmark_um;
  if (at === undefined || at === null) return undefined;
  const parts = partsOf(target);
  const out: { solid: PointMm[][]; faint: PointMm[][] } = { solid: [], faint: [] };
  for (const part of parts) addPart(part, at, target, out);
  return out;
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
  const middle: Point2 = [at[0]! + part.top_um[0]!, at[1]! + part.top_um[1]!];
  const topUm = at[2]! + part.top_um[2]!;
  if (part.outline === "stump") {
    const rings = stumpRings(part, middle, topUm);
    if (rings !== undefined) out.solid.push(...rings, ...joins(...rings, 1));
    return;
  }
  const corners = cornersOf(part);
  const every = part.outline === "disc" ? kDiscPoints / kDiscJoins : 1;
  const opening = ringOf(corners, middle, topUm);
  out.solid.push(opening);
  // A floor that is not level is the tooth's own shape: no line tells it.
  if (part.relief !== undefined) return;
  const floor = ringOf(corners, middle, topUm - part.depth_um);
  out.solid.push(floor, ...joins(opening, floor, every));
  const wider = grown(corners, target.leeway_side_um);
  out.faint.push(ringOf(wider, middle, topUm), ringOf(wider, middle, topUm - part.depth_um - target.leeway_bottom_um));
}

// Foot and table.
function stumpRings({ stump, depth_um: depth }: Part, middle: Point2, topUm: number) {
  if (stump === undefined) return undefined;
  const { foot, table, table_below_um: below } = stump;
  return [
    ringOf(rectangle(foot.half_um as unknown as Point2), shifted(middle, foot.middle_um), topUm - depth),
    ringOf(rectangle(table.half_um as unknown as Point2), shifted(middle, table.middle_um), topUm - below),
  ] as const;
}

// Sides and ends of each part. Undefined: there is none, or the server does not say where it is. A part whose floor is
// the tooth's own shape has none: its depth differs from place to place.
export function bodyOfTarget(target: Target): Body | undefined {
  const at = target.landmark_um;
  const position: number[] = [];
  const triangle: number[] = [];
  for (const part of at === undefined || at === null ? [] : partsOf(target)) {
    const middle: Point2 = [at![0]! + part.top_um[0]!, at![1]! + part.top_um[1]!];
    const topUm = at![2]! + part.top_um[2]!;
    const corners = cornersOf(part);
    const rings =
      part.outline === "stump"
        ? stumpRings(part, middle, topUm)
        : part.relief === undefined
          ? ([ringOf(corners, middle, topUm - part.depth_um), ringOf(corners, middle, topUm)] as const)
          : undefined;
    if (rings === undefined) continue;
    const first = position.length / 3;
    const n = rings[0].length - 1; // the last place of a ring is its first
    for (const ring of rings) position.push(...ring.slice(0, n).flat());
    for (let i = 0; i < n; ++i) {
      const [a, b, c, d] = [i, (i + 1) % n, n + ((i + 1) % n), n + i].map((own) => first + own) as [
        number,
        number,
        number,
        number,
      ];
      triangle.push(a, b, c, a, c, d);
    }
    for (const [a, b, c] of trianglesIn(rings[0]!.slice(0, n))) {
      triangle.push(first + a, first + c, first + b);
      triangle.push(first + n + a, first + n + b, first + n + c);
    }
  }
  if (triangle.length === 0) return undefined;
  return { positionMm: Float32Array.from(position), triangle: Uint16Array.from(triangle) };
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

function ringOf(corners: readonly Point2[], middle: Point2, zUm: number): PointMm[] {
  return [...corners, ...corners.slice(0, 1)].map(
    ([x, y]): PointMm => [(middle[0] + x) / 1000, (middle[1] + y) / 1000, zUm / 1000],
  );
}

function joins(above: readonly PointMm[], below: readonly PointMm[], every: number): PointMm[][] {
  return above.slice(0, -1).flatMap((point, i) => (i % every === 0 ? [[point, below[i]!]] : []));
}
