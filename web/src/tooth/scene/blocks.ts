import type { BlockMesh } from "../mesher";
import { type Gl, Shape } from "./gl";
import { withStain } from "./stain";
import { TriangleGrid } from "./triangle_grid";
import { lengthOf, type Matrix, sub, type Vec } from "./vec";

// A tooth in blocks, each with its own triangles, so that only cut blocks go to the graphics card
// again.

const kTrianglesInCell = 4; // about, of what is looked up by a ray
const kMaxCellsAlong = 96;

export interface BlockHit {
  readonly mesh: BlockMesh;
  readonly vertex: number; // of the triangle that is met
  readonly at: Vec;
}

export interface Box {
  readonly low: Vec;
  readonly high: Vec;
}

interface Block {
  readonly mesh: BlockMesh;
  readonly drawn: Shape;
  readonly box: Box;
  translucent: boolean; // has what shines through it
  grid: TriangleGrid | undefined; // made when a ray first comes near
}

export class ToothBlocks {
  private readonly blocks = new Map<number, Block>();

  constructor(private readonly gl: Gl) {}

  dispose(): void {
    for (const { drawn } of this.blocks.values()) drawn.dispose();
    this.blocks.clear();
  }

  set(index: number, mesh: BlockMesh | undefined): void {
    this.blocks.get(index)?.drawn.dispose();
    this.blocks.delete(index);
    if (mesh === undefined) return;
    const { positionMm, normal, colored = mesh.deviation, triangle } = mesh;
    const drawn = new Shape(
      this.gl,
      {
        position: { data: positionMm, size: 3 },
        normal: { data: normal, size: 4, normalized: true },
        tissue: { data: withStain(mesh), size: 1 },
        deviation: colored === undefined ? undefined : { data: colored, size: 2 },
      },
      triangle,
    );
    this.blocks.set(index, { mesh, drawn, box: boxOf(positionMm), translucent: false, grid: undefined });
  }

  setLooks(looks: (mesh: BlockMesh) => Uint8Array<ArrayBuffer> | undefined): void {
    for (const block of this.blocks.values()) {
      const own = block.translucent ? undefined : looks(block.mesh);
      if (own === undefined) continue;
      block.drawn.add("own", { data: own, size: 4, normalized: true });
      block.translucent = true;
    }
  }

  // Those that may be in the picture, whose matrix it is.
  draw(picture: Matrix): void {
    for (const { drawn, box } of this.blocks.values()) if (isInPicture(box, picture)) drawn.draw();
  }

  meshes(): Iterable<{ readonly mesh: BlockMesh; readonly box: Box }> {
    return this.blocks.values();
  }

  // What a ray meets first. `direction` need not have the length 1.
  firstHit(origin: Vec, direction: Vec, meets: (point: Vec) => boolean): BlockHit | undefined {
    const near = [...this.blocks.values()]
      .flatMap((block) => {
        const from = entersAt(block.box, origin, direction);
        return from === undefined ? [] : [{ block, from: from * lengthOf(direction) }];
      })
      .sort((a, b) => a.from - b.from);
    let best: BlockHit | undefined;
    let nearest = Infinity;
    for (const { block, from } of near) {
      if (from > nearest) break;
      block.grid ??= new TriangleGrid(
        block.mesh.positionMm,
        block.mesh.triangle,
        cellsAlong(block.mesh.triangle.length / 3),
      );
      const hit = block.grid.firstHit(origin, direction, meets);
      if (hit === undefined) continue;
      const along = lengthOf(sub(hit.at, origin));
      if (along >= nearest) continue;
      nearest = along;
      best = { mesh: block.mesh, vertex: block.mesh.triangle[3 * hit.triangle]!, at: hit.at };
    }
    return best;
  }
}

// Triangles lie on a surface, and so in the square of these cells.
function cellsAlong(triangles: number): number {
  return Math.min(kMaxCellsAlong, Math.ceil(Math.sqrt(triangles / kTrianglesInCell)));
}

export function boxOf(position: Float32Array): Box {
  const low: [number, number, number] = [Infinity, Infinity, Infinity];
  const high: [number, number, number] = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < position.length; i += 3)
    for (let axis = 0; axis < 3; ++axis) {
      const value = position[i + axis]!;
      if (value < low[axis]!) low[axis] = value;
      if (value > high[axis]!) high[axis] = value;
    }
  return { low, high };
}

// False: all corners are beyond one edge of the picture.
function isInPicture({ low, high }: Box, m: Matrix): boolean {
  let beyond = 63; // left, right, below, above, before, behind
  for (let corner = 0; corner < 8; ++corner) {
    const x = corner & 1 ? high[0] : low[0];
    const y = corner & 2 ? high[1] : low[1];
    const z = corner & 4 ? high[2] : low[2];
    const at = (row: number) => m[row]! * x + m[row + 4]! * y + m[row + 8]! * z + m[row + 12]!;
    const w = at(3);
    let out = 0;
    for (let axis = 0; axis < 3; ++axis) out |= (at(axis) < -w ? 1 : at(axis) > w ? 2 : 0) << (2 * axis);
    beyond &= out;
  }
  return beyond === 0;
}

// How far along a ray it comes into the box, 0 where it begins there. Undefined: never.
function entersAt({ low, high }: Box, origin: Vec, direction: Vec): number | undefined {
  let [enter, leave] = [0, Infinity];
  for (let axis = 0; axis < 3; ++axis) {
    const [a, b] = [low, high].map((side) => (side[axis]! - origin[axis]!) / direction[axis]!) as [number, number];
    // Along a side of the box: 0 / 0.
    if (Number.isNaN(a) || Number.isNaN(b)) continue;
    enter = Math.max(enter, Math.min(a, b));
    leave = Math.min(leave, Math.max(a, b));
  }
  return enter > leave ? undefined : enter;
}
