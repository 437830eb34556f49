import type { SectionPlane } from "../messages";
import type { Box } from "./blocks";
import { kCutColor } from "../line_colors";
import { screenColor } from "./colors";
import { drawOver, type Gl, type Program, Shape } from "./gl";
import { crossings, type Plane } from "./plane_cut";
import { add, dot, type Matrix, product, scaled, unit, type Vec } from "./vec";

// A plane that hides what is in front of it, and the line along which it cuts the tooth.

export interface Cuttable {
  readonly mesh: { readonly positionMm: Float32Array; readonly triangle: Uint32Array | Uint16Array };
  readonly box: Box;
}

const kCorners = [
  [-1, -1],
  [1, -1],
  [-1, 1],
  [1, 1],
] as const; // of a pixel, whose side is 2 / width
const kAxes = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] } as const;

// `sight`: from the target to the camera; what is nearer to the viewer goes.
export function normalOf({ across, flipped }: SectionPlane, sight: Vec = kAxes.z): Vec {
  return scaled(across === "view" ? unit(scaled(sight, -1)) : kAxes[across], flipped ? -1 : 1);
}

export class Section {
  plane: Plane = [0, 0, 1, 0]; // what lies behind it, against its normal, is hidden
  private outline: Shape | undefined;
  private plan: SectionPlane | undefined;
  private stale = false;

  constructor(
    private readonly gl: Gl,
    private readonly color = kCutColor,
  ) {}
  dispose(): void {
    this.outline?.dispose();
    this.outline = undefined;
  }

  get wanted(): SectionPlane | undefined {
    return this.plan;
  }
  get on(): boolean {
    return this.plan !== undefined;
  }
  set(wanted: SectionPlane | undefined): void {
    this.plan = wanted;
    this.stale = true;
  }
  // What is cut has changed.
  changed(): void {
    this.stale = true;
  }

  // Before each picture. `sight`: from the target to the camera.
  update(centre: Vec, radius: number, sight: Vec, parts: () => Iterable<Cuttable>): void {
    if (this.plan === undefined) return;
    const { share, flipped } = this.plan;
    const [x, y, z] = normalOf(this.plan, sight);
    const through = add(centre, scaled([x, y, z], (flipped ? -1 : 1) * share * radius));
    const plane: Plane = [x, y, z, -dot([x, y, z], through)];
    if (!this.stale && plane.every((value, i) => value === this.plane[i])) return;
    this.plane = plane;
    this.stale = false;
    this.cut(parts());
  }

  // Where a ray meets the plane.
  meets(origin: Vec, way: Vec): Vec {
    const [x, y, z] = this.plane;
    return add(origin, scaled(way, -heightOver(this.plane, origin) / dot([x, y, z], way)));
  }

  isShown(at: Vec): boolean {
    return !this.on || heightOver(this.plane, at) >= 0;
  }

  // `plain`: in use, with the picture's matrices. Browsers draw lines one pixel wide: it is drawn at each corner of one.
  draw(plain: Program, projection: Matrix): void {
    if (!this.on) return;
    const { gl } = this;
    drawOver(gl, { depth: false });
    plain.set("tint", [...screenColor(this.color), 1]);
    for (const [right, up] of kCorners) {
      const aside = [right / gl.drawingBufferWidth, up / gl.drawingBufferHeight] as const;
      plain.set("projection", product([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, ...aside, 0, 1], projection));
      this.outline?.draw();
    }
    plain.set("projection", projection);
  }

  private cut(parts: Iterable<Cuttable>): void {
    const [x, y, z, constant] = this.plane;
    const lines: number[] = [];
    for (const { mesh, box } of parts) {
      if (meets(box, this.plane)) crossings(mesh.positionMm, mesh.triangle, [x, y, z], constant, lines);
    }
    this.outline?.dispose();
    this.outline = new Shape(
      this.gl,
      { position: { data: Float32Array.from(lines), size: 3 } },
      undefined,
      this.gl.LINES,
    );
  }
}

function heightOver([x, y, z, constant]: Plane, at: Vec): number {
  return dot([x, y, z], at) + constant;
}
// Whether corners of the box lie on both sides.
function meets({ low, high }: Box, plane: Plane): boolean {
  const farthest = (a: Vec, b: Vec) => [0, 1, 2].map((axis) => (plane[axis]! > 0 ? a : b)[axis]!) as unknown as Vec;
  return heightOver(plane, farthest(high, low)) >= 0 && heightOver(plane, farthest(low, high)) <= 0;
}
