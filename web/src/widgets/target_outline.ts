import type { StumpSection, Target, TargetPart } from "../api/types";

// What an exercise asks for, seen from above, as paths of a drawing: x to the right,
// y (buccal) up, um.

export interface OutlinePath {
  readonly d: string;
  readonly what: "goes" | "stays";
}

// y grows downward in a drawing.
const point = (x: number, y: number): string => `${Math.round(x)} ${Math.round(-y)}`;

function rectangle(x: number, y: number, halfX: number, halfY: number, corner = 0): string {
  const r = Math.min(corner, halfX, halfY);
  if (r === 0) {
    return `M ${point(x - halfX, y - halfY)} L ${point(x + halfX, y - halfY)} L ${point(x + halfX, y + halfY)} L ${point(x - halfX, y + halfY)} Z`;
  }
  const arc = (toX: number, toY: number) => `A ${r} ${r} 0 0 0 ${point(toX, toY)}`;
  return [
    `M ${point(x - halfX + r, y - halfY)}`,
    `L ${point(x + halfX - r, y - halfY)}`,
    arc(x + halfX, y - halfY + r),
    `L ${point(x + halfX, y + halfY - r)}`,
    arc(x + halfX - r, y + halfY),
    `L ${point(x - halfX + r, y + halfY)}`,
    arc(x - halfX, y + halfY - r),
    `L ${point(x - halfX, y - halfY + r)}`,
    arc(x - halfX + r, y - halfY),
    "Z",
  ].join(" ");
}

function partPaths(part: TargetPart): OutlinePath[] {
  const [x = 0, y = 0] = part.top_um;
  const [halfX = 0, halfY = 0] = part.half_size_um ?? [];
  if (part.outline === "disc") {
    const r = part.radius_um ?? 0;
    return [
      {
        what: "goes",
        d: `M ${point(x - r, y)} A ${r} ${r} 0 0 0 ${point(x + r, y)} A ${r} ${r} 0 0 0 ${point(x - r, y)} Z`,
      },
    ];
  }
  if (part.outline === "polygon") {
    const corners = (part.corners_um ?? []).map(([cx = 0, cy = 0]) => point(x + cx, y + cy));
    return [{ what: "goes", d: `M ${corners.join(" L ")} Z` }];
  }
  const goes: OutlinePath = { what: "goes", d: rectangle(x, y, halfX, halfY) };
  const stump = part.stump;
  if (stump === undefined) return [goes];
  const stays = (section: StumpSection): OutlinePath => {
    const [middleX = 0, middleY = 0] = section.middle_um,
      [sectionX = 0, sectionY = 0] = section.half_um;
    return { what: "stays", d: rectangle(x + middleX, y + middleY, sectionX, sectionY, stump.corner_um) };
  };
  return [goes, stays(stump.foot), stays(stump.table)];
}

export function outlinePaths(target: Target): OutlinePath[] {
  const [halfX = 0, halfY = 0] = target.half_size_um;
  return target.parts.length === 0
    ? [{ what: "goes", d: rectangle(0, 0, halfX, halfY) }]
    : target.parts.flatMap(partPaths);
}

// With room for the leeway all around.
export function outlineViewBox(target: Target): string {
  const [halfX = 0, halfY = 0] = target.half_size_um;
  const room = target.leeway_side_um + 300;
  return `${-halfX - room} ${-halfY - room} ${2 * (halfX + room)} ${2 * (halfY + room)}`;
}
