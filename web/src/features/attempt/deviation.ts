import type { MesialX } from "../../api/tooth_number";
import type { Compared } from "../../tooth/messages";
import { angledFrom } from "../../widgets/tooth/angled";

// A score charges nothing that is no farther than this from the acceptable cut: schemas/score.md.
export const kLeewayMm = 0.1;

// The deviation map in numbers, for people who do not or cannot see the picture. Counted by vertex:
// the surface comes from a grid, so vertices lie nearly evenly over its area.

export type CavitySide = "mesial_wall" | "distal_wall" | "buccal_wall" | "lingual_wall" | "floor";

export interface SideDeviation {
  readonly side: CavitySide;
  readonly vertices: number;
  readonly meanMm: number;
  readonly mostMm: number; // the deviation of greatest size, with its sign
}

// Where to look from, and at what, to see the side that deviates most.
export interface Outlook {
  readonly direction: Point;
  readonly centre: Point | undefined;
}
type Point = readonly [number, number, number];

export interface DeviationSummary {
  readonly vertices: number; // compared with the reference
  readonly withinShare: number; // |deviation| <= kLeewayMm
  readonly overShare: number; // more removed than that
  readonly underShare: number;
  readonly p95Mm: number; // of the size
  readonly sides: readonly SideDeviation[]; // most deviating first; only sides that have vertices
}

const kFacing = 0.7; // a normal's component along a side's direction, about 45 degrees

// A wall of the cavity faces inward: the mesial wall's outward normal points distally. The first two
// are along x, with mesial at +x.
const kSides: ReadonlyArray<readonly [CavitySide, number, number]> = [
  ["mesial_wall", 0, -1],
  ["distal_wall", 0, 1],
  ["buccal_wall", 1, -1],
  ["lingual_wall", 1, 1],
  ["floor", 2, 1],
];

// With mesial at +x.
const kOutlooks: Readonly<Record<string, Point>> = {
  mesial_wall: [-0.75, -0.45, 1],
  distal_wall: [0.75, -0.45, 1],
  buccal_wall: [0.4, -0.75, 1],
  lingual_wall: [-0.4, 0.75, 1],
};

export function outlook(
  surface: Compared | undefined,
  worst: CavitySide | undefined,
  mesial: MesialX | undefined,
): Outlook {
  if (worst === undefined || surface === undefined) return { direction: angledFrom(mesial), centre: undefined };
  const centre = comparedCentre(surface);
  const wall = kOutlooks[worst];
  if (wall === undefined) return { direction: angledFrom(mesial), centre };
  const [x, y, z] = wall;
  return { direction: [x * (mesial ?? 1), y, z], centre };
}

function comparedCentre({ positionMm, deviationMm }: Compared): Point | undefined {
  const sum = [0, 0, 0];
  let count = 0;
  deviationMm.forEach((value, vertex) => {
    if (Number.isNaN(value)) return;
    ++count;
    for (let axis = 0; axis < 3; ++axis) sum[axis]! += positionMm[3 * vertex + axis]!;
  });
  return count === 0 ? undefined : [sum[0]! / count, sum[1]! / count, sum[2]! / count];
}

// While it is not known where mesial is, the walls along x are left out of the sides.
export function summariseDeviation(surface: Compared, mesial: MesialX | undefined): DeviationSummary | undefined {
  const { deviationMm } = surface;
  const sizes: number[] = [];
  let over = 0;
  let under = 0;
  const sides = kSides.map(() => ({ vertices: 0, sum: 0, most: 0 }));
  deviationMm.forEach((value, vertex) => {
    if (Number.isNaN(value)) return;
    sizes.push(Math.abs(value));
    if (value > kLeewayMm) ++over;
    if (value < -kLeewayMm) ++under;
    const side = sides[sideOf(surface, vertex, mesial)];
    if (side === undefined) return;
    ++side.vertices;
    side.sum += value;
    if (Math.abs(value) > Math.abs(side.most)) side.most = value;
  });
  if (sizes.length === 0) return undefined;
  const n = sizes.length;
  return {
    vertices: n,
    overShare: over / n,
    underShare: under / n,
    withinShare: (n - over - under) / n,
    p95Mm: percentile(sizes, 0.95),
    sides: kSides
      .map(([name], i) => ({ name, side: sides[i]! }))
      .filter(({ side }) => side.vertices > 0)
      .map(({ name, side }) => ({
        side: name,
        vertices: side.vertices,
        meanMm: side.sum / side.vertices,
        mostMm: side.most,
      }))
      .sort((a, b) => Math.abs(b.meanMm) - Math.abs(a.meanMm)),
  };
}

function sideOf(surface: Compared, vertex: number, mesial: MesialX | undefined): number {
  return kSides.findIndex(
    ([, axis, sign]) => (sign * (axis === 0 ? (mesial ?? 0) : 1) * surface.normal[4 * vertex + axis]!) / 127 > kFacing,
  );
}

function percentile(values: number[], share: number): number {
  values.sort((a, b) => a - b);
  return values[Math.min(values.length - 1, Math.floor(share * values.length))] ?? 0;
}
