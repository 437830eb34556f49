import { kBrickSide, kDeep, kFarOut, type TimelinePlayer } from "./timeline";

// Triangles of a tooth's samples, by surface nets, as common/surface/surface.cpp makes them: a vertex in each cell that the
// surface crosses, at the mean of its edges' crossings; a quad for each crossed edge, split along its shorter diagonal.
// Made block by block, so that only what was cut is made anew.

const kBlockBricks = 4;                         // along each axis
const kBlock = kBlockBricks * kBrickSide;
const kSide = kBlock + 2;                       // with a layer of the neighbours' samples around
const kCells = kBlock + 1;

export interface BlockMesh {
  readonly positionMm: Float32Array<ArrayBuffer>;  // (n x 3), scene frame
  readonly normal: Int8Array<ArrayBuffer>;      // (n x 4), x y z 0, /127, outward
  readonly tissue: Uint8Array<ArrayBuffer>;     // (n)
  readonly triangle: Uint16Array<ArrayBuffer>;  // (m x 3), counter-clockwise seen from outside
}

// A cell's edges by their corners: four along x, four along y, four along z. Corner i is (i & 1, i >> 1 & 1, i >> 2).
const kEdgeFrom = [0, 2, 4, 6, 0, 1, 4, 5, 0, 1, 2, 3] as const;
const kEdgeTo = [1, 3, 5, 7, 2, 3, 6, 7, 4, 5, 6, 7] as const;
const kStep = [1, kSide, kSide * kSide] as const;
const kCellStep = [1, kCells, kCells * kCells] as const;

// Makes the meshes of a player's tooth as it is now. Owns buffers that it uses again: one mesh at a time.
export class ToothMesher {
  private readonly samples = new Int8Array(kSide ** 3);
  private readonly vertexOf = new Int32Array(kCells ** 3);
  private readonly corner = new Float32Array(8);
  private readonly blocks: readonly [number, number, number];
  private position: number[] = [];
  private normal: number[] = [];
  private tissue: number[] = [];
  private triangle: number[] = [];
  private first: [number, number, number] = [0, 0, 0];  // voxel of local sample (0, 0, 0)

  constructor(private readonly player: TimelinePlayer) {
    const across = (bricks: number) => Math.ceil(bricks / kBlockBricks);
    const [x, y, z] = player.start.grid.bricks;
    this.blocks = [across(x), across(y), across(z)];
  }

  // All blocks that may hold surface.
  allBlocks(): number[] {
    const { start } = this.player;
    const out = new Set<number>();
    for (let b = 0; b < start.bricks.length; ++b) if (start.slot[b]! >= 0) this.blocksAt(b, out);
    return [...out].sort((a, b) => a - b);
  }
  // The blocks whose mesh a change of these bricks can change.
  blocksOf(bricks: Iterable<number>): Set<number> {
    const out = new Set<number>();
    for (const brick of bricks) this.blocksAt(brick, out);
    return out;
  }
  private blocksAt(brick: number, out: Set<number>): void {
    const [nx, ny] = this.player.start.grid.bricks;
    const at = [brick % nx, Math.floor(brick / nx) % ny, Math.floor(brick / (nx * ny))] as const;
    const range = (axis: 0 | 1 | 2) => [Math.max(0, at[axis] - 1) >> 2, Math.min((at[axis] + 1) >> 2, this.blocks[axis] - 1)] as const;
    const [x, y, z] = [range(0), range(1), range(2)];
    for (let k = z[0]; k <= z[1]; ++k) {
      for (let j = y[0]; j <= y[1]; ++j) {
        for (let i = x[0]; i <= x[1]; ++i) out.add((k * this.blocks[1] + j) * this.blocks[0] + i);
      }
    }
  }

  // Undefined: no surface passes there.
  mesh(block: number): BlockMesh | undefined {
    const [nx, ny] = this.blocks;
    const at = [block % nx, Math.floor(block / nx) % ny, Math.floor(block / (nx * ny))] as const;
    this.first = [at[0] * kBlock - 1, at[1] * kBlock - 1, at[2] * kBlock - 1];
    if (!this.gather()) return undefined;
    this.position = [];
    this.normal = [];
    this.tissue = [];
    this.triangle = [];
    this.vertexOf.fill(-1);
    this.quads(at);
    if (this.triangle.length === 0) return undefined;
    return { positionMm: Float32Array.from(this.position), normal: Int8Array.from(this.normal), tissue: Uint8Array.from(this.tissue), triangle: Uint16Array.from(this.triangle) };
  }

  // False: all samples are on one side.
  private gather(): boolean {
    const [bx, by, bz] = this.player.start.grid.bricks;
    const side = [0, 0];
    const local = (voxel: number, axis: 0 | 1 | 2) => voxel - this.first[axis];
    const from = this.first.map((v) => Math.floor(v / kBrickSide)) as [number, number, number];
    for (let k = from[2]; k <= from[2] + kBlockBricks + 1; ++k) {
      for (let j = from[1]; j <= from[1] + kBlockBricks + 1; ++j) {
        for (let i = from[0]; i <= from[0] + kBlockBricks + 1; ++i) {
          const inside = i >= 0 && j >= 0 && k >= 0 && i < bx && j < by && k < bz;
          const samples = inside ? this.player.samples((k * by + j) * bx + i) : kFarOut;
          this.copyBrick(samples, local(i * kBrickSide, 0), local(j * kBrickSide, 1), local(k * kBrickSide, 2), side);
        }
      }
    }
    return side[0] !== 0 && side[1] !== 0;
  }

  // `x`, `y`, `z`: local place of the brick's first sample; what lies outside the block is left out.
  private copyBrick(samples: Int8Array | number, x: number, y: number, z: number, side: number[]): void {
    const x0 = Math.max(0, -x);
    const x1 = Math.min(kBrickSide, kSide - x);
    for (let k = Math.max(0, -z); k < Math.min(kBrickSide, kSide - z); ++k) {
      for (let j = Math.max(0, -y); j < Math.min(kBrickSide, kSide - y); ++j) {
        const to = ((z + k) * kSide + y + j) * kSide + x;
        const from = k * 64 + j * 8;
        for (let i = x0; i < x1; ++i) {
          const q = typeof samples === "number" ? samples : samples[from + i]!;
          this.samples[to + i] = q;
          ++side[q < 0 ? 0 : 1]!;
        }
      }
    }
  }

  // Of the crossed edges whose first sample is the block's, or lies one voxel below the grid.
  private quads(at: readonly [number, number, number]): void {
    const s = this.samples;
    const lowest = at.map((n) => (n === 0 ? 0 : 1)) as [number, number, number];
    for (let z = lowest[2]; z <= kBlock; ++z) {
      for (let y = lowest[1]; y <= kBlock; ++y) {
        for (let x = lowest[0]; x <= kBlock; ++x) {
          const n = (z * kSide + y) * kSide + x;
          const inside = s[n]! < 0;
          for (let axis = 0; axis < 3; ++axis) {
            if (s[n + kStep[axis]!]! < 0 !== inside) this.quad(x, y, z, axis, inside);
          }
        }
      }
    }
  }

  private quad(x: number, y: number, z: number, axis: number, inside: boolean): void {
    const u = kCellStep[(axis + 1) % 3]!;
    const w = kCellStep[(axis + 2) % 3]!;
    const cell = (z * kCells + y) * kCells + x;
    // Counter-clockwise seen from the far end of the edge, since u x w is along it.
    const a = this.vertex(cell - u - w);
    const b = this.vertex(inside ? cell - w : cell - u);
    const c = this.vertex(cell);
    const d = this.vertex(inside ? cell - u : cell - w);
    if (this.length2(a, c) <= this.length2(b, d)) this.triangle.push(a, b, c, a, c, d);
    else this.triangle.push(a, b, d, b, c, d);
  }
  private length2(a: number, b: number): number {
    const p = this.position;
    return (p[3 * a]! - p[3 * b]!) ** 2 + (p[3 * a + 1]! - p[3 * b + 1]!) ** 2 + (p[3 * a + 2]! - p[3 * b + 2]!) ** 2;
  }

  private vertex(cell: number): number {
    const known = this.vertexOf[cell]!;
    if (known >= 0) return known;
    const x = cell % kCells;
    const y = Math.floor(cell / kCells) % kCells;
    const z = Math.floor(cell / (kCells * kCells));
    const n = (z * kSide + y) * kSide + x;
    const v = this.corner;
    // Each stands for half a step more: 0 has no side.
    for (let i = 0; i < 8; ++i) v[i] = this.samples[n + (i & 1) + (i >> 1 & 1) * kSide + (i >> 2) * kSide * kSide]! + 0.5;
    const p = meanCrossing(v);
    const index = this.tissue.length;
    this.vertexOf[cell] = index;
    const { voxelMm, originMm } = this.player.start.grid;
    const voxel = [this.first[0] + x, this.first[1] + y, this.first[2] + z] as const;
    for (let axis = 0; axis < 3; ++axis) this.position.push(originMm[axis]! + (voxel[axis]! + p[axis]!) * voxelMm);
    this.normal.push(...normalAt(v, p), 0);
    const under = nearestInside(v, p);
    this.tissue.push(this.tissueAt(voxel[0] + (under & 1), voxel[1] + (under >> 1 & 1), voxel[2] + (under >> 2)));
    return index;
  }
  private tissueAt(x: number, y: number, z: number): number {
    const [nx, ny] = this.player.start.grid.bricks;
    return this.player.tissue(((z >> 3) * ny + (y >> 3)) * nx + (x >> 3), (z & 7) * 64 + (y & 7) * 8 + (x & 7));
  }
}

type Triple = [number, number, number];

// Of the crossings of a cell's edges. Needs: at least one.
function meanCrossing(v: Float32Array): Triple {
  const sum: Triple = [0, 0, 0];
  let count = 0;
  for (let e = 0; e < 12; ++e) {
    const from = kEdgeFrom[e]!;
    const [a, b] = [v[from]!, v[kEdgeTo[e]!]!];
    if (a < 0 === b < 0) continue;
    ++count;
    const along = e >> 2;
    for (let axis = 0; axis < 3; ++axis) sum[axis]! += axis === along ? a / (a - b) : from >> axis & 1;
  }
  return [sum[0] / count, sum[1] / count, sum[2] / count];
}

// Gradient of the trilinear interpolation, /127; where it vanishes, from the inside corners to the outside ones.
function normalAt(v: Float32Array, p: Triple): Triple {
  const g: Triple = [0, 0, 0];
  for (let e = 0; e < 12; ++e) {
    const from = kEdgeFrom[e]!;
    const along = e >> 2;
    let weight = v[kEdgeTo[e]!]! - v[from]!;
    for (let axis = 0; axis < 3; ++axis) if (axis !== along) weight *= from >> axis & 1 ? p[axis]! : 1 - p[axis]!;
    g[along]! += weight;
  }
  let length = Math.hypot(...g);
  if (length < 0.05 * -kDeep) {
    g.fill(0);
    for (let i = 0; i < 8; ++i) for (let axis = 0; axis < 3; ++axis) g[axis]! += ((i >> axis & 1) - 0.5) * (v[i]! < 0 ? -1 : 1);
    length = Math.hypot(...g);
    if (length === 0) return [0, 0, 127];
  }
  return [Math.round(127 * g[0] / length), Math.round(127 * g[1] / length), Math.round(127 * g[2] / length)];
}

function nearestInside(v: Float32Array, p: Triple): number {
  let nearest = Infinity;
  let corner = 0;
  for (let i = 0; i < 8; ++i) {
    if (v[i]! >= 0) continue;
    const d2 = (p[0] - (i & 1)) ** 2 + (p[1] - (i >> 1 & 1)) ** 2 + (p[2] - (i >> 2)) ** 2;
    if (d2 >= nearest) continue;
    nearest = d2;
    corner = i;
  }
  return corner;
}
