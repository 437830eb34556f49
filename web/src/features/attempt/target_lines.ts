import type { Exercise } from "../../api/types";
import type { PointMm, ToothLines } from "../../tooth/messages";

// What the exercise asks for, as lines in the scene's frame: of each part the opening and the
// floor, joined at the corners, and how far beside it may be cut (the leeway).

type Target = Exercise["target"];
type Part = Target["parts"][number];
type Point2 = readonly [number, number];

const kDiscPoints = 48,
  kDiscJoins = 4;

// Undefined: the server does not say where the target hangs.
export function linesOfTarget(target: Target): ToothLines | undefined {
  const at = target.landmark_um;
  if (at === undefined || at === null) return undefined;
  const parts = target.parts.length > 0 ? target.parts : [boxOf(target)];
  const out: { solid: PointMm[][]; faint: PointMm[][] } = { solid: [], faint: [] };
  for (const part of parts) addPart(part, at, target, out);
  return out;
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
    if (part.stump === undefined) return;
    const { foot, table, table_below_um: below } = part.stump;
    const rings = [
      ringOf(rectangle(foot.half_um as unknown as Point2), shifted(middle, foot.middle_um), topUm - part.depth_um),
      ringOf(rectangle(table.half_um as unknown as Point2), shifted(middle, table.middle_um), topUm - below),
    ] as const;
    out.solid.push(...rings, ...joins(...rings, 1));
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
