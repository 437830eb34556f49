import type { Exercise } from "../../api/types";
import { type Json, valueAt } from "../../base/document";
import { formatLimit, formatPoints, usualDigits } from "../../base/format";
import { say, sayIf } from "../../base/words";

// What a part of the cut costs over the size of its fault: the curve of common/scoring/mistakes/prices.h, and its figures
// in words.

export type Price = Exercise["rubric"]["prices"][number];
export type Side = "over" | "left";

export const kSides: readonly Side[] = ["over", "left"];
export const kChosen = "chosen"; // the source of figures that were not read anywhere

interface Measured {
  readonly unit: Price["unit"];
  readonly over?: string; // the member of a document with its size
  readonly left?: string;
}

const kOfRegion: Measured = { unit: "mm", over: "over_mm", left: "left_mm" };

// In the order in which a form offers them.
export const kPriced = {
  floor: kOfRegion,
  wall: kOfRegion,
  table: kOfRegion,
  axial_wall: kOfRegion,
  margin: kOfRegion,
  face: kOfRegion,
  line_angle: kOfRegion,
  elsewhere: { unit: "mm3", over: "over_mm3" },
  neighbour: { unit: "mm", over: "over_mm" },
  pulp: { unit: "mm3", over: "over_mm3" },
  caries: { unit: "%", left: "left_percent" },
} as const satisfies Readonly<Partial<Record<Price["of"], Measured>>>;
export type PricedKind = keyof typeof kPriced;

export function measuredOf(kind: Json | undefined): Measured | undefined {
  return typeof kind === "string" && Object.hasOwn(kPriced, kind) ? kPriced[kind as PricedKind] : undefined;
}

export function priceTitle(kind: string): string {
  return sayIf(`price_kind.${kind}`) ?? kind;
}

export interface Curve {
  readonly size: number; // that costs about `points`
  readonly points: number;
  readonly most: number;
}

export function costAt({ size, points, most }: Curve, at: number): number {
  const straight = (points * at) / size;
  return straight / Math.hypot(1, straight / most);
}

// The size that costs so many points; undefined: none does.
export function sizeAt({ size, points, most }: Curve, cost: number): number | undefined {
  return cost < most ? (cost / Math.sqrt(1 - (cost / most) ** 2) / points) * size : undefined;
}

export function curveOf({ points, most, ...sizes }: Price, side: Side): Curve | undefined {
  const size = sizes[side];
  return size === null ? undefined : { size, points, most };
}

// Of a document that is being edited; undefined while its figures give no curve.
export function priceOf(item: Json): Price | undefined {
  const of = valueAt(item, ["of"]);
  const measured = measuredOf(of);
  if (measured === undefined) return undefined;
  const above = (member: string): number | undefined => {
    const value = valueAt(item, [member]);
    return typeof value === "number" && Number.isFinite(value) && value > 0 ? value : undefined;
  };
  const sizes = kSides.map((side) => {
    const member = measured[side];
    return member === undefined ? null : above(member);
  });
  const figures = ["points", "most", "modify_points", "redo_points"].map(above);
  const [over, left] = sizes;
  const [points, most, modify, redo] = figures;
  if (over === undefined || left === undefined) return undefined;
  if (points === undefined || most === undefined || modify === undefined || redo === undefined) return undefined;
  const source = valueAt(item, ["source"]);
  return {
    of: of as PricedKind,
    unit: measured.unit,
    over,
    left,
    points,
    most,
    modify_points: modify,
    redo_points: redo,
    source: typeof source === "string" ? source : "",
  };
}

// A new price of a kind, to be edited.
export function freshPrice(kind: PricedKind): Json {
  const { unit, ...members }: Measured = kPriced[kind];
  const size = { mm: 0.5, mm3: 1, "%": 10 }[unit as "mm" | "mm3" | "%"];
  return {
    of: kind,
    ...Object.fromEntries(Object.values(members).map((member) => [member, size])),
    points: 10,
    most: 30,
    modify_points: 2,
    redo_points: 10,
    source: kChosen,
  };
}

const kAbout = 0.9; // of `points`: where the curve bends more, its own figure is said

// What the price's sizes cost.
export function aboutPoints(price: Price): number {
  const cost = Math.min(
    ...kSides.map((side) => {
      const curve = curveOf(price, side);
      return curve === undefined ? price.points : costAt(curve, curve.size);
    }),
  );
  return cost >= kAbout * price.points ? price.points : cost;
}

// "0.45 mm too far over a whole wall, or 0.60 mm left on it, costs about 12 points. It never costs more than 36."
export function priceText(price: Price): string {
  const size = (side: Side) => formatLimit(price[side] ?? Number.NaN, price.unit);
  return (
    sayIf(`price_costs.${price.of}`, {
      over: size("over"),
      left: size("left"),
      points: formatPoints(aboutPoints(price)),
      most: formatPoints(price.most),
    }) ?? ""
  );
}

// The sizes that cost so many points, each a line: "0.09 mm too far", "0.12 mm left".
export function sizesText(price: Price, points: number): string[] {
  const sizes = kSides.map((side) => {
    const curve = curveOf(price, side);
    return curve === undefined ? undefined : sizeAt(curve, points);
  });
  const [over, left] = sizes.map((size) => (size === undefined ? undefined : roundedText(size, price.unit)));
  if (over !== undefined && over === left) return [say("price.either", { size: over })];
  // What was taken from a neighbour or elsewhere has no other side to tell it from.
  const alone = price.over === null || price.left === null;
  return [
    ...(over === undefined ? [] : [alone ? over : say("price.size_over", { size: over })]),
    ...(left === undefined ? [] : [alone ? left : say("price.size_left", { size: left })]),
  ];
}

// In the unit's usual form; what that would show as 0 by its first digit.
function roundedText(size: number, unit: string): string {
  const usual = Number(size.toFixed(usualDigits(unit) ?? 2));
  return formatLimit(usual > 0 ? usual : Number(size.toPrecision(1)), unit);
}
