import { kBrickSide, kDeep, kFarOut, type StillTooth } from "./timeline";
import { kNotCompared, type ToothDeviation } from "./tooth_deviation";

// Triangles of a tooth's samples, by surface nets, as common/surface/surface.cpp makes them: a
// vertex in each cell that the surface crosses, at the mean of its edges' crossings; a quad for
// each crossed edge, split along its shorter diagonal. Made block by block, so that only what was
// cut is meshed again.

const kBlockBricks = 4; // along each axis
const kBlock = kBlockBricks * kBrickSide;
const kSide = kBlock + 2; // with a layer of the neighbours' samples around
export const kCells = kBlock + 1; // of a block along each axis; the outer ones are its neighbours' too

export interface BlockMesh {
  readonly positionMm: Float32Array<ArrayBuffer>; // (n x 3), scene frame
  readonly normal: Int8Array<ArrayBuffer>; // (n x 4), x y z 0, /127, outward
  readonly tissue: Uint8Array<ArrayBuffer>; // (n)
  readonly deviation: Float32Array<ArrayBuffer> | undefined; // (n x 2): mm, + = more removed than the reference; 1, or 0 and 0 where not compared
  readonly triangle: Uint16Array<ArrayBuffer> | Uint32Array<ArrayBuffer>; // (m x 3), counter-clockwise seen from outside
}

// A cell's edges by their corners: four along x, four along y, four along z. Corner i is (i & 1, i
// >> 1 & 1, i >> 2).
const kEdgeFrom = Uint8Array.of(0, 2, 4, 6, 0, 1, 4, 5, 0, 1, 2, 3);
const kEdgeTo = Uint8Array.of(1, 3, 5, 7, 2, 3, 6, 7, 4, 5, 6, 7);
const kStep = Int32Array.of(1, kSide, kSide * kSide);
const kCellStep = Int32Array.of(1, kCells, kCells * kCells);
const kNextTo = 1 / 16; // of a cell
const kFlat = 0.05 * -kDeep; // of a gradient: below it the direction is rounding, not shape

// Makes the meshes of a tooth as it is now. Owns buffers that it uses again, one mesh at a
// time: a whole tooth is hundreds of thousands of vertices, and an object for each would be most of
// the time.
export class ToothMesher {
  private readonly samples = new Int8Array(kSide ** 3);
  private readonly vertexOf = new Int32Array(kCells ** 3);
  private readonly position = new Float32Array(3 * kCells ** 3);
  private readonly normal = new Int8Array(4 * kCells ** 3);
  private readonly tissue = new Uint8Array(kCells ** 3);
  private readonly compared = new Float32Array(2 * kCells ** 3);
  // Of the tooth at its end; vertices of cells that it knows carry it, at whatever moment.
  deviation: ToothDeviation | undefined;
  private triangle = new Uint16Array(1 << 16);
  private vertices = 0;
  private corners = 0; // of triangles
  private readonly v = new Float64Array(8); // a cell's corners
  private readonly p = new Float64Array(3); // its vertex
  private readonly g = new Float64Array(3);
  private readonly first = new Int32Array(3); // voxel of local sample (0, 0, 0)
  private readonly blocks: readonly [number, number, number];

  constructor(private readonly player: StillTooth) {
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
    const range = (axis: 0 | 1 | 2) =>
      [Math.max(0, at[axis] - 1) >> 2, Math.min((at[axis] + 1) >> 2, this.blocks[axis] - 1)] as const;
    const [x, y, z] = [range(0), range(1), range(2)];
    for (let k = z[0]; k <= z[1]; ++k) {
      for (let j = y[0]; j <= y[1]; ++j) {
        for (let i = x[0]; i <= x[1]; ++i) out.add((k * this.blocks[1] + j) * this.blocks[0] + i);
      }
    }
  }

  // Of each vertex of the last mesh, its cell in the block.
  cells(): Int32Array {
    const out = new Int32Array(this.vertices);
    this.vertexOf.forEach((vertex, cell) => {
      if (vertex >= 0) out[vertex] = cell;
    });
    return out;
  }
  // Of the block's last mesh, the vertices that the block before does not have too: neighbours
  // share those of a layer.
  ownVertices(): number[] {
    const out: number[] = [];
    this.vertexOf.forEach((vertex, cell) => {
      const row = Math.floor(cell / kCells);
      if (vertex >= 0 && cell % kCells !== 0 && row % kCells !== 0 && row >= kCells) out.push(vertex);
    });
    return out;
  }

  // Undefined: no surface passes there.
  mesh(block: number): BlockMesh | undefined {
    const [nx, ny] = this.blocks;
    const at = [block % nx, Math.floor(block / nx) % ny, Math.floor(block / (nx * ny))] as const;
    at.forEach((n, axis) => {
      this.first[axis] = n * kBlock - 1;
    });
    if (!this.gather()) return undefined;
    this.vertexOf.fill(-1);
    this.vertices = this.corners = 0;
    this.quads(at);
    if (this.corners === 0) return undefined;
    return {
      positionMm: this.position.slice(0, 3 * this.vertices),
      normal: this.normal.slice(0, 4 * this.vertices),
      tissue: this.tissue.slice(0, this.vertices),
      deviation: this.deviation === undefined ? undefined : this.compared.slice(0, 2 * this.vertices),
      triangle: this.triangle.slice(0, this.corners),
    };
  }

  // False: all samples are on one side.
  private gather(): boolean {
    const [bx, by, bz] = this.player.start.grid.bricks;
    const [fx, fy, fz] = [this.first[0]!, this.first[1]!, this.first[2]!];
    let any = 0;
    let all = -1;
    for (let k = fz >> 3; k <= (fz >> 3) + kBlockBricks + 1; ++k) {
      for (let j = fy >> 3; j <= (fy >> 3) + kBlockBricks + 1; ++j) {
        for (let i = fx >> 3; i <= (fx >> 3) + kBlockBricks + 1; ++i) {
          const inside = i >= 0 && j >= 0 && k >= 0 && i < bx && j < by && k < bz;
          const samples = inside ? this.player.samples((k * by + j) * bx + i) : kFarOut;
          const [x, y, z] = [i * kBrickSide - fx, j * kBrickSide - fy, k * kBrickSide - fz];
          if (typeof samples === "number") {
            this.fillBrick(samples, x, y, z);
            any |= samples;
            all &= samples;
          } else {
            const sides = this.copyBrick(samples, x, y, z);
            if (sides & 1) any = -1;
            if (sides & 2) all = 0;
          }
        }
      }
    }
    return any < 0 && all >= 0;
  }

  // `x`, `y`, `z`: local place of the brick's first sample; what lies outside the block is left
  // out.
  private fillBrick(q: number, x: number, y: number, z: number): void {
    for (let k = Math.max(0, z); k < Math.min(kSide, z + kBrickSide); ++k) {
      for (let j = Math.max(0, y); j < Math.min(kSide, y + kBrickSide); ++j) {
        const row = (k * kSide + j) * kSide;
        this.samples.fill(q, row + Math.max(0, x), row + Math.min(kSide, x + kBrickSide));
      }
    }
  }
  // Bit 0: some are solid; bit 1: some are air.
  private copyBrick(from: Int8Array, x: number, y: number, z: number): number {
    const to = this.samples;
    const x0 = Math.max(0, x);
    const x1 = Math.min(kSide, x + kBrickSide);
    let any = 0;
    let all = -1;
    for (let k = Math.max(0, z); k < Math.min(kSide, z + kBrickSide); ++k) {
      for (let j = Math.max(0, y); j < Math.min(kSide, y + kBrickSide); ++j) {
        const row = (k * kSide + j) * kSide;
        const own = (k - z) * 64 + (j - y) * 8 - x;
        for (let i = x0; i < x1; ++i) {
          const q = from[own + i]!;
          to[row + i] = q;
          any |= q;
          all &= q;
        }
      }
    }
    return (any < 0 ? 1 : 0) | (all >= 0 ? 2 : 0);
  }

  // Of the crossed edges whose first sample is the block's, or lies one voxel below the grid.
  private quads(at: readonly [number, number, number]): void {
    const s = this.samples;
    const [lx, ly, lz] = at.map((n) => (n === 0 ? 0 : 1)) as [number, number, number];
    for (let z = lz; z <= kBlock; ++z) {
      for (let y = ly; y <= kBlock; ++y) {
        let n = (z * kSide + y) * kSide + lx;
        for (let x = lx; x <= kBlock; ++x, ++n) {
          const side = s[n]! >> 7;
          const crossed =
            (side ^ (s[n + 1]! >> 7)) | (side ^ (s[n + kSide]! >> 7)) | (side ^ (s[n + kSide * kSide]! >> 7));
          if (crossed === 0) continue;
          for (let axis = 0; axis < 3; ++axis) {
            if (s[n + kStep[axis]!]! >> 7 !== side) this.quad(x, y, z, axis, side < 0);
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
    if (this.length2(a, c) <= this.length2(b, d)) {
      this.addTriangle(a, b, c);
      this.addTriangle(a, c, d);
    } else {
      this.addTriangle(a, b, d);
      this.addTriangle(b, c, d);
    }
  }
  private addTriangle(a: number, b: number, c: number): void {
    if (this.corners + 3 > this.triangle.length) {
      const more = new Uint16Array(2 * this.triangle.length);
      more.set(this.triangle);
      this.triangle = more;
    }
    this.triangle[this.corners++] = a;
    this.triangle[this.corners++] = b;
    this.triangle[this.corners++] = c;
  }
  private length2(a: number, b: number): number {
    const p = this.position;
    const [x, y, z] = [p[3 * a]! - p[3 * b]!, p[3 * a + 1]! - p[3 * b + 1]!, p[3 * a + 2]! - p[3 * b + 2]!];
    return x * x + y * y + z * z;
  }

  private vertex(cell: number): number {
    const known = this.vertexOf[cell]!;
    if (known >= 0) return known;
    const x = cell % kCells;
    const row = (cell - x) / kCells;
    const y = row % kCells;
    const z = (row - y) / kCells;
    const n = (z * kSide + y) * kSide + x;
    // Each stands for half a step more: 0 has no side.
    for (let i = 0; i < 8; ++i)
      this.v[i] = this.samples[n + (i & 1) + ((i >> 1) & 1) * kSide + (i >> 2) * kSide * kSide]! + 0.5;
    this.meanCrossing();
    const index = this.vertices++;
    this.vertexOf[cell] = index;
    const { voxelMm, originMm } = this.player.start.grid;
    const [vx, vy, vz] = [this.first[0]! + x, this.first[1]! + y, this.first[2]! + z];
    this.position[3 * index] = originMm[0] + (vx + this.p[0]!) * voxelMm;
    this.position[3 * index + 1] = originMm[1] + (vy + this.p[1]!) * voxelMm;
    this.position[3 * index + 2] = originMm[2] + (vz + this.p[2]!) * voxelMm;
    this.gradient();
    for (let axis = 0; axis < 3; ++axis) this.normal[4 * index + axis] = Math.round(127 * this.g[axis]!);
    const under = this.nearestInside();
    this.tissue[index] = this.tissueAt(vx + (under & 1), vy + ((under >> 1) & 1), vz + (under >> 2));
    if (this.deviation !== undefined) this.compare(index, [vx, vy, vz], this.deviation);
    return index;
  }
  private compare(index: number, cell: readonly [number, number, number], deviation: ToothDeviation): void {
    const um = this.deviationOf(cell, deviation) ?? this.deviationBeside(cell, deviation);
    this.compared[2 * index] = um === undefined ? 0 : um / 1000;
    this.compared[2 * index + 1] = um === undefined ? 0 : 1;
  }
  private deviationOf([x, y, z]: readonly [number, number, number], { bricks }: ToothDeviation): number | undefined {
    const [nx, ny] = this.player.start.grid.bricks;
    if (x < 0 || y < 0 || z < 0) return undefined;
    const um = bricks.get(((z >> 3) * ny + (y >> 3)) * nx + (x >> 3))?.[(z & 7) * 64 + (y & 7) * 8 + (x & 7)];
    return um === kNotCompared ? undefined : um;
  }
  // Cells that are not the block's count as crossed.
  private isCrossed(cell: readonly [number, number, number]): boolean {
    const [x, y, z] = cell.map((n, axis) => n - this.first[axis]!) as [number, number, number];
    if ([x, y, z].some((n) => n < 0 || n >= kCells)) return true;
    let solid = 0;
    for (let i = 0; i < 8; ++i)
      if (this.samples[((z + (i >> 2)) * kSide + y + ((i >> 1) & 1)) * kSide + x + (i & 1)]! < 0) ++solid;
    return solid !== 0 && solid !== 8;
  }
  // Of the cell beyond the border that the vertex at `p` is next to: where it was made its position
  // was rounded.
  private deviationBeside([x, y, z]: readonly [number, number, number], deviation: ToothDeviation): number | undefined {
    for (let axis = 0; axis < 3; ++axis) {
      const at = this.p[axis]!;
      const step = at < kNextTo ? -1 : at > 1 - kNextTo ? 1 : 0;
      if (step === 0) continue;
      const beside = [x, y, z] as [number, number, number];
      beside[axis]! += step;
      const um = this.deviationOf(beside, deviation);
      if (um !== undefined && !this.isCrossed(beside)) return um;
    }
    return undefined;
  }
  private tissueAt(x: number, y: number, z: number): number {
    const [nx, ny] = this.player.start.grid.bricks;
    return this.player.tissue(((z >> 3) * ny + (y >> 3)) * nx + (x >> 3), (z & 7) * 64 + (y & 7) * 8 + (x & 7));
  }

  // p: the mean of the crossings of the cell's edges. Needs: at least one.
  private meanCrossing(): void {
    const { v, p } = this;
    p.fill(0);
    let count = 0;
    for (let e = 0; e < 12; ++e) {
      const from = kEdgeFrom[e]!;
      const a = v[from]!;
      const b = v[kEdgeTo[e]!]!;
      if (a < 0 === b < 0) continue;
      ++count;
      const along = e >> 2;
      p[0]! += along === 0 ? a / (a - b) : from & 1;
      p[1]! += along === 1 ? a / (a - b) : (from >> 1) & 1;
      p[2]! += along === 2 ? a / (a - b) : from >> 2;
    }
    for (let axis = 0; axis < 3; ++axis) p[axis]! /= count;
  }

  // g: the direction of the trilinear interpolation's gradient at p; where it vanishes, from the
  // inside corners to the outside ones.
  private gradient(): void {
    const { v, p, g } = this;
    g.fill(0);
    for (let e = 0; e < 12; ++e) {
      const from = kEdgeFrom[e]!;
      const along = e >> 2;
      const wx = along === 0 ? 1 : from & 1 ? p[0]! : 1 - p[0]!;
      const wy = along === 1 ? 1 : from & 2 ? p[1]! : 1 - p[1]!;
      const wz = along === 2 ? 1 : from & 4 ? p[2]! : 1 - p[2]!;
      g[along]! += (v[kEdgeTo[e]!]! - v[from]!) * wx * wy * wz;
    }
    let length = Math.sqrt(g[0]! * g[0]! + g[1]! * g[1]! + g[2]! * g[2]!);
    if (length < kFlat) {
      g.fill(0);
      for (let i = 0; i < 8; ++i)
        for (let axis = 0; axis < 3; ++axis) g[axis]! += (((i >> axis) & 1) - 0.5) * (v[i]! < 0 ? -1 : 1);
      length = Math.sqrt(g[0]! * g[0]! + g[1]! * g[1]! + g[2]! * g[2]!);
    }
    if (length === 0) {
      g[2] = 1;
      return;
    }
    for (let axis = 0; axis < 3; ++axis) g[axis]! /= length;
  }

  private nearestInside(): number {
    const { v, p } = this;
    let nearest = Infinity;
    let corner = 0;
    for (let i = 0; i < 8; ++i) {
      if (v[i]! >= 0) continue;
      const [x, y, z] = [p[0]! - (i & 1), p[1]! - ((i >> 1) & 1), p[2]! - (i >> 2)];
      const d2 = x * x + y * y + z * z;
      if (d2 >= nearest) continue;
      nearest = d2;
      corner = i;
    }
    return corner;
  }
}
