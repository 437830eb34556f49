import { type ChangingPart, kTriangles } from "./changing";
import { kNotCompared, type ToothDeviation } from "./deviation";
import { kBrickSide, kCoarse, kDeep, kFarOut, kSteps } from "./samples";

// Triangles of a tooth's samples, by surface nets, as common/surface/surface.cpp makes them: a
// vertex in each cell that the surface crosses, at the mean of its edges' crossings; a quad for
// each crossed edge, split along its shorter diagonal. Made block by block, so that only what was
// cut is meshed again, and only of the bricks that change: a mesh has the rest (part_mesh.ts).

const kBlockBricks = 4; // along each axis
const kBlock = kBlockBricks * kBrickSide;
const kMargin = 2; // layers of the neighbours' samples around a block
const kSide = kBlock + 2 * kMargin;
const kNear = kBlockBricks + 2; // bricks of a block along each axis, with a layer of its neighbours around
const kCells = kBlock + 1; // of a block along each axis; the outer ones are its neighbours' too

export interface BlockMesh {
  readonly positionMm: Float32Array<ArrayBuffer>; // (n x 3), scene frame
  readonly normal: Int8Array<ArrayBuffer>; // (n x 4), x y z 0, /127, outward
  readonly tissue: Uint8Array<ArrayBuffer>; // (n)
  readonly cut?: Uint8Array<ArrayBuffer>; // (n): other than 0 where a bur was
  readonly deviation: Float32Array<ArrayBuffer> | undefined; // (n x 2): mm, + = more removed than the reference; 1, or 0 and 0 where not compared
  // (n x 2): the deviation times a share, and that share: one half along the border of what was compared.
  readonly colored?: Float32Array<ArrayBuffer> | undefined;
  readonly triangle: Uint16Array<ArrayBuffer> | Uint32Array<ArrayBuffer>; // (m x 3), counter-clockwise seen from outside
}

const kWholeRow = (1 << kBrickSide) - 1; // of a brick's samples
const kLastOfRow = 1 << (kBrickSide - 1);
const kCellStep = Int32Array.of(1, kCells, kCells * kCells);
const kFlat = 0.05 * -kDeep; // of a gradient: below it the direction is rounding, not shape

// Of a voxel in its brick.
const sampleOf = (x: number, y: number, z: number) => (z & 7) * 64 + (y & 7) * 8 + (x & 7);

// Makes the meshes of a tooth as it is now. Owns buffers that it uses again, one mesh at a
// time: a whole tooth is hundreds of thousands of vertices, and an object for each would be most of
// the time.
export class ToothMesher {
  private readonly samples = new Int8Array(kSide ** 3);
  // Of the block's bricks and their neighbours: bit 0: some samples are solid; bit 1: some are air. 0: nothing needs it.
  private readonly sides = new Uint8Array(kNear ** 3);
  // Of each row of samples, a byte for each brick along it: a bit for each sample, set where it is solid.
  private readonly solid = new Uint8Array(kNear * kSide ** 2);
  private readonly vertexOf = new Int32Array(kCells ** 3);
  private readonly position = new Float32Array(3 * kCells ** 3);
  private readonly normal = new Int8Array(4 * kCells ** 3);
  private readonly tissue = new Uint8Array(kCells ** 3);
  private readonly cut = new Uint8Array(kCells ** 3);
  private readonly along = [new Float64Array(8), new Float64Array(8), new Float64Array(8)] as const; // splineAt
  private readonly slope = new Float64Array(3);
  private readonly compared = new Float32Array(2 * kCells ** 3);
  private readonly colored = new Float32Array(2 * kCells ** 3);
  private readonly values = new Int32Array(kSide ** 3); // of the deviation, in the cell at each sample
  // Of the tooth at its end; vertices of cells that it knows carry it, at whatever moment.
  deviation: ToothDeviation | undefined;
  private triangle = new Uint16Array(1 << 16);
  private vertices = 0;
  private corners = 0; // of triangles
  private readonly first = new Int32Array(3); // voxel at which cell (0, 0, 0) begins
  private readonly blocks: readonly [number, number, number];

  constructor(private readonly part: ChangingPart) {
    const across = (bricks: number) => Math.ceil(bricks / kBlockBricks);
    const [x, y, z] = part.bricks.grid.bricks;
    this.blocks = [across(x), across(y), across(z)];
  }

  // All that have bricks which change.
  allBlocks(): number[] {
    const [nx, ny] = this.part.bricks.grid.bricks;
    const out = new Set<number>();
    for (const b of this.part.bricks.changing) {
      const at = [b % nx, Math.floor(b / nx) % ny, Math.floor(b / (nx * ny))].map((n) => n >> 2) as [
        number,
        number,
        number,
      ];
      out.add((at[2] * this.blocks[1] + at[1]) * this.blocks[0] + at[0]);
    }
    return [...out].sort((a, b) => a - b);
  }
  // The blocks whose mesh a change of these bricks can change.
  blocksOf(bricks: Iterable<number>): Set<number> {
    const out = new Set<number>();
    for (const brick of bricks) this.blocksAt(brick, out);
    return out;
  }
  private blocksAt(brick: number, out: Set<number>): void {
    const [nx, ny] = this.part.bricks.grid.bricks;
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
    this.sides.fill(0);
    if (!this.nearQuads(at) || !this.gather()) return undefined;
    this.vertexOf.fill(-1);
    this.vertices = this.corners = 0;
    this.quads(at);
    if (this.corners === 0) return undefined;
    return {
      positionMm: this.position.slice(0, 3 * this.vertices),
      normal: this.normal.slice(0, 4 * this.vertices),
      tissue: this.tissue.slice(0, this.vertices),
      cut: this.cut.slice(0, this.vertices),
      ...(this.deviation === undefined
        ? { deviation: undefined }
        : {
            deviation: this.compared.slice(0, 2 * this.vertices),
            colored: this.colored.slice(0, 2 * this.vertices),
          }),
      triangle: this.triangle.slice(0, this.corners),
    };
  }

  // Marks the block's bricks that have triangles, and all around them. False: there is none.
  private nearQuads(at: readonly [number, number, number]): boolean {
    let found = false;
    this.eachOwn(at, (i, j, k) => {
      found = true;
      for (let z = k; z < k + 3; ++z)
        for (let y = j; y < j + 3; ++y)
          this.sides.fill(1, (z * kNear + y) * kNear + i, (z * kNear + y) * kNear + i + 3);
    });
    return found;
  }

  // The samples of what is marked. False: all are on one side.
  private gather(): boolean {
    const [bx, by, bz] = this.part.bricks.grid.bricks;
    const [fx, fy, fz] = [this.first[0]! >> 3, this.first[1]! >> 3, this.first[2]! >> 3];
    let all = 0;
    if (this.deviation !== undefined) this.values.fill(kNotCompared);
    for (let z = 0, n = 0; z < kNear; ++z) {
      for (let y = 0; y < kNear; ++y) {
        for (let x = 0; x < kNear; ++x, ++n) {
          if (this.sides[n] === 0) continue;
          const i = fx + x;
          const j = fy + y;
          const k = fz + z;
          const inside = i >= 0 && j >= 0 && k >= 0 && i < bx && j < by && k < bz;
          const brick = inside ? (k * by + j) * bx + i : -1;
          const cells = this.deviation?.bricks.get(brick);
          all |= this.sides[n] = this.copyBrick(inside ? this.part.samples(brick) : kFarOut, cells, x, y, z);
        }
      }
    }
    return all === 3;
  }

  // `from`: its samples, or what all of them are; `cells`: its deviation; `x`, `y`, `z`: which one it is of those near the block. What lies
  // outside the block is left out. Bit 0: some are solid; bit 1: some are air.
  private copyBrick(from: Int8Array | number, cells: Int32Array | undefined, x: number, y: number, z: number): number {
    const { samples: to, values } = this;
    const [ox, oy, oz] = [x, y, z].map((n) => (n - 1) * kBrickSide + kMargin) as [number, number, number];
    const x0 = Math.max(0, ox);
    const x1 = Math.min(kSide, ox + kBrickSide);
    const y0 = Math.max(0, oy);
    const y1 = Math.min(kSide, oy + kBrickSide);
    const z0 = Math.max(0, oz);
    const z1 = Math.min(kSide, oz + kBrickSide);
    const every = (1 << (x1 - ox)) - (1 << (x0 - ox));
    let some = 0;
    let air = 0;
    for (let k = z0; k < z1; ++k) {
      for (let j = y0; j < y1; ++j) {
        const row = k * kSide + j;
        const end = row * kSide + x1;
        if (cells !== undefined) {
          let cell = (k - oz) * 64 + (j - oy) * 8 + x0 - ox;
          for (let at = row * kSide + x0; at < end; ++at, ++cell) values[at] = cells[cell]!;
        }
        let at = row * kSide + x0;
        let solid = 0;
        if (typeof from === "number") {
          for (; at < end; ++at) to[at] = from;
          if (from < 0) solid = every;
        } else {
          let own = (k - oz) * 64 + (j - oy) * 8 + x0 - ox;
          for (let bit = x0 - ox; at < end; ++at, ++own, ++bit) {
            const q = from[own]!;
            to[at] = q;
            solid |= (q >>> 31) << bit;
          }
        }
        this.solid[row * kNear + x] = solid;
        some |= solid;
        air |= every & ~solid;
      }
    }
    return (some === 0 ? 0 : 1) | (air === 0 ? 0 : 2);
  }

  // Of the bricks that change, in the block.
  private quads(at: readonly [number, number, number]): void {
    this.eachOwn(at, (i, j, k) => {
      const first = [at[0] === 0 && i === 0, at[1] === 0 && j === 0, at[2] === 0 && k === 0] as const;
      if (this.mayCross(i, j, k, first)) this.brickQuads(i, j, k, first);
    });
  }
  // Each that has triangles, by its place in the block.
  private eachOwn(at: readonly [number, number, number], act: (i: number, j: number, k: number) => void): void {
    const { grid, flags } = this.part.bricks;
    const [bx, by, bz] = grid.bricks;
    const [ex, ey, ez] = [bx, by, bz].map((n, axis) => Math.min(kBlockBricks, n - at[axis]! * kBlockBricks)) as [
      number,
      number,
      number,
    ];
    for (let k = 0; k < ez; ++k) {
      for (let j = 0; j < ey; ++j) {
        for (let i = 0; i < ex; ++i) {
          const [x, y, z] = [at[0] * kBlockBricks + i, at[1] * kBlockBricks + j, at[2] * kBlockBricks + k];
          if (flags[(z * by + y) * bx + x]! & kTriangles) act(i, j, k);
        }
      }
    }
  }
  // False: its samples, and those its edges lead to, are all on one side.
  private mayCross(i: number, j: number, k: number, first: readonly [boolean, boolean, boolean]): boolean {
    const own = ((k + 1) * kNear + j + 1) * kNear + i + 1;
    let sides = this.sides[own]! | this.sides[own + 1]! | this.sides[own + kNear]! | this.sides[own + kNear * kNear]!;
    if (first[0]) sides |= this.sides[own - 1]!;
    if (first[1]) sides |= this.sides[own - kNear]!;
    if (first[2]) sides |= this.sides[own - kNear * kNear]!;
    return sides === 3;
  }
  // Of the crossed edges whose first sample is the brick's; with those one voxel below the grid, where the brick
  // is the grid's first.
  private brickQuads(i: number, j: number, k: number, first: readonly [boolean, boolean, boolean]): void {
    const [oy, oz] = [j * kBrickSide + kMargin, k * kBrickSide + kMargin];
    for (let z = first[2] ? oz - 1 : oz; z < oz + kBrickSide; ++z) {
      for (let y = first[1] ? oy - 1 : oy; y < oy + kBrickSide; ++y) {
        if (first[0]) this.rowQuads(0, y, z, kLastOfRow);
        this.rowQuads(i + 1, y, z, kWholeRow);
      }
    }
  }
  // Of the samples of a row that are in the near brick `nx`; `which`: a bit for each that counts.
  private rowQuads(nx: number, y: number, z: number, which: number): void {
    const { solid } = this;
    const at = (z * kSide + y) * kNear + nx;
    const own = solid[at]!;
    const alongX = own ^ ((own >> 1) | ((solid[at + 1]! & 1) << (kBrickSide - 1)));
    const alongY = own ^ solid[at + kNear]!;
    const alongZ = own ^ solid[at + kNear * kSide]!;
    for (let left = (alongX | alongY | alongZ) & which; left !== 0; left &= left - 1) {
      const bit = 31 - Math.clz32(left & -left);
      const x = (nx - 1) * kBrickSide + kMargin + bit;
      const inside = ((own >> bit) & 1) === 1;
      if ((alongX >> bit) & 1) this.quad(x, y, z, 0, inside);
      if ((alongY >> bit) & 1) this.quad(x, y, z, 1, inside);
      if ((alongZ >> bit) & 1) this.quad(x, y, z, 2, inside);
    }
  }

  private quad(x: number, y: number, z: number, axis: number, inside: boolean): void {
    const u = kCellStep[(axis + 1) % 3]!;
    const w = kCellStep[(axis + 2) % 3]!;
    const cell = ((z - 1) * kCells + y - 1) * kCells + x - 1;
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
    const n = ((z + 1) * kSide + y + 1) * kSide + x + 1;
    const index = this.vertices++;
    this.vertexOf[cell] = index;
    const [vx, vy, vz] = [this.first[0]! + x, this.first[1]! + y, this.first[2]! + z];
    const under = this.place(n, index, vx, vy, vz);
    const ux = under & 1;
    const uy = (under >> 1) & 1;
    const uz = under >> 2;
    const brick = this.brickOf(vx + ux, vy + uy, vz + uz);
    const sample = sampleOf(vx + ux, vy + uy, vz + uz);
    this.tissue[index] = this.part.tissue(brick, sample);
    const start = this.part.startSamples(brick);
    const now = this.samples[n + (uz * kSide + uy) * kSide + ux]!;
    // Of the same level: before the last segment no more is known.
    this.cut[index] = now >> kCoarse === (typeof start === "number" ? start : start[sample]!) >> kCoarse ? 0 : 1;
    if (this.deviation !== undefined) this.compare(index, n);
    return index;
  }
  private isCrossed(n: number): boolean {
    const s = this.samples;
    const m = n + kSide * kSide;
    const all =
      s[n]! & s[n + 1]! & s[n + kSide]! & s[n + kSide + 1]! & s[m]! & s[m + 1]! & s[m + kSide]! & s[m + kSide + 1]!;
    const any =
      s[n]! | s[n + 1]! | s[n + kSide]! | s[n + kSide + 1]! | s[m]! | s[m + 1]! | s[m + kSide]! | s[m + kSide + 1]!;
    return (all ^ any) < 0; // their signs differ
  }
  // Cell by cell the border of what was compared is torn. Its colours end where as many of the cells around have none.
  private compare(index: number, n: number): void {
    const { values } = this;
    const own = values[n]!;
    let [known, sum, all] = [0, 0, 0];
    for (let k = -1; k < 2; ++k)
      for (let j = -1; j < 2; ++j)
        for (let i = -1; i < 2; ++i) {
          const m = n + (k * kSide + j) * kSide + i;
          const weight = (2 - k * k) * (2 - j * j) * (2 - i * i);
          if (values[m] !== kNotCompared) {
            known += weight;
            sum += weight * values[m]!;
          } else if (!this.isCrossed(m)) continue;
          all += weight;
        }
    const mm = (own === kNotCompared ? sum / (known || 1) : own) / 1000;
    const share = known / all;
    this.compared[2 * index] = own === kNotCompared ? 0 : mm;
    this.compared[2 * index + 1] = own === kNotCompared ? 0 : 1;
    this.colored[2 * index] = share * mm;
    this.colored[2 * index + 1] = share;
  }
  private brickOf(x: number, y: number, z: number): number {
    const { bricks } = this.part.bricks.grid;
    return ((z >> 3) * bricks[1] + (y >> 3)) * bricks[0] + (x >> 3);
  }

  // Where the vertex of the cell at sample `n`, of voxel (vx, vy, vz), is and where it points; returns the inside corner
  // that it is nearest to. Written out edge by edge: a tooth has hundreds of thousands, at each moment thousands.
  private place(n: number, index: number, vx: number, vy: number, vz: number): number {
    const s = this.samples;
    // Corner i is (i & 1, i >> 1 & 1, i >> 2). Each sample stands for half a step more: 0 has no side.
    const v0 = s[n]! + 0.5;
    const v1 = s[n + 1]! + 0.5;
    const v2 = s[n + kSide]! + 0.5;
    const v3 = s[n + kSide + 1]! + 0.5;
    const m = n + kSide * kSide;
    const v4 = s[m]! + 0.5;
    const v5 = s[m + 1]! + 0.5;
    const v6 = s[m + kSide]! + 0.5;
    const v7 = s[m + kSide + 1]! + 0.5;
    const [x01, x23, x45, x67] = [crossing(v0, v1), crossing(v2, v3), crossing(v4, v5), crossing(v6, v7)];
    const [y02, y13, y46, y57] = [crossing(v0, v2), crossing(v1, v3), crossing(v4, v6), crossing(v5, v7)];
    const [z04, z15, z26, z37] = [crossing(v0, v4), crossing(v1, v5), crossing(v2, v6), crossing(v3, v7)];
    // The mean of the crossings of the cell's edges, of which there is at least one.
    const onX = one(x01) + one(x23) + one(x45) + one(x67);
    const onY = one(y02) + one(y13) + one(y46) + one(y57);
    const count = onX + onY + one(z04) + one(z15) + one(z26) + one(z37);
    const px = (x01 + x23 + x45 + x67 + one(y13) + one(y57) + one(z15) + one(z37)) / count;
    const py = (one(x23) + one(x67) + y02 + y13 + y46 + y57 + one(z26) + one(z37)) / count;
    const pz = (one(x45) + one(x67) + one(y46) + one(y57) + z04 + z15 + z26 + z37) / count;
    const { voxelMm, originMm } = this.part.bricks.grid;
    // In the steps of a mesh, which what does not change has.
    this.position[3 * index] = originMm[0] + (vx + Math.round(kSteps * px) / kSteps) * voxelMm;
    this.position[3 * index + 1] = originMm[1] + (vy + Math.round(kSteps * py) / kSteps) * voxelMm;
    this.position[3 * index + 2] = originMm[2] + (vz + Math.round(kSteps * pz) / kSteps) * voxelMm;
    this.gradient(n, px, py, pz);
    let [gx, gy, gz] = [this.slope[0]!, this.slope[1]!, this.slope[2]!];
    let length = Math.sqrt(gx * gx + gy * gy + gz * gz);
    // Where it vanishes, from the inside corners to the outside ones.
    if (length < kFlat) {
      gx = side(v1) - side(v0) + side(v3) - side(v2) + side(v5) - side(v4) + side(v7) - side(v6);
      gy = side(v2) - side(v0) + side(v3) - side(v1) + side(v6) - side(v4) + side(v7) - side(v5);
      gz = side(v4) - side(v0) + side(v5) - side(v1) + side(v6) - side(v2) + side(v7) - side(v3);
      length = Math.sqrt(gx * gx + gy * gy + gz * gz);
      if (length === 0) gz = length = 1;
    }
    this.normal[4 * index] = Math.round((127 * gx) / length);
    this.normal[4 * index + 1] = Math.round((127 * gy) / length);
    this.normal[4 * index + 2] = Math.round((127 * gz) / length);
    // Squares of the distances to the corners that are inside.
    const [x0, y0, z0] = [px * px, py * py, pz * pz];
    const [x1, y1, z1] = [(1 - px) ** 2, (1 - py) ** 2, (1 - pz) ** 2];
    const d0 = v0 < 0 ? x0 + y0 + z0 : Infinity;
    const d1 = v1 < 0 ? x1 + y0 + z0 : Infinity;
    const d2 = v2 < 0 ? x0 + y1 + z0 : Infinity;
    const d3 = v3 < 0 ? x1 + y1 + z0 : Infinity;
    const d4 = v4 < 0 ? x0 + y0 + z1 : Infinity;
    const d5 = v5 < 0 ? x1 + y0 + z1 : Infinity;
    const d6 = v6 < 0 ? x0 + y1 + z1 : Infinity;
    const d7 = v7 < 0 ? x1 + y1 + z1 : Infinity;
    const least = Math.min(d0, d1, d2, d3, d4, d5, d6, d7);
    if (least === d0) return 0;
    if (least === d1) return 1;
    if (least === d2) return 2;
    if (least === d3) return 3;
    if (least === d4) return 4;
    if (least === d5) return 5;
    return least === d6 ? 6 : 7;
  }

  // Of a cubic B-spline over the samples, in the cell of sample `n`, into `slope`. The samples are held within a voxel
  // of the surface, and where two walls meet those of one cell alone point anywhere along the edge: over four along
  // each axis both even out.
  private gradient(n: number, px: number, py: number, pz: number): void {
    const { samples, slope } = this;
    const [x, y, z] = this.along;
    splineAt(px, x);
    splineAt(py, y);
    splineAt(pz, z);
    const [x0, x1, x2, x3] = [x[0]!, x[1]!, x[2]!, x[3]!];
    const [s0, s1, s2, s3] = [x[4]!, x[5]!, x[6]!, x[7]!];
    let gx = 0;
    let gy = 0;
    let gz = 0;
    for (let k = 0; k < 4; ++k) {
      let value = 0;
      let alongX = 0;
      let alongY = 0;
      let at = n - 1 + ((k - 1) * kSide - 1) * kSide;
      for (let j = 0; j < 4; ++j, at += kSide) {
        const a = samples[at]!;
        const b = samples[at + 1]!;
        const c = samples[at + 2]!;
        const d = samples[at + 3]!;
        const row = x0 * a + x1 * b + x2 * c + x3 * d;
        value += y[j]! * row;
        alongX += y[j]! * (s0 * a + s1 * b + s2 * c + s3 * d);
        alongY += y[4 + j]! * row;
      }
      gx += z[k]! * alongX;
      gy += z[k]! * alongY;
      gz += z[4 + k]! * value;
    }
    slope[0] = gx;
    slope[1] = gy;
    slope[2] = gz;
  }
}

// Of a cubic B-spline's four weights at `p` between its middle two samples, and of their slopes.
function splineAt(p: number, out: Float64Array): void {
  const q = 1 - p;
  out[0] = (q * q * q) / 6;
  out[1] = 2 / 3 - p * p * (1 - p / 2);
  out[2] = 2 / 3 - q * q * (1 - q / 2);
  out[3] = (p * p * p) / 6;
  out[4] = (-q * q) / 2;
  out[5] = p * (1.5 * p - 2);
  out[6] = q * (2 - 1.5 * q);
  out[7] = (p * p) / 2;
}

// How far along an edge with these ends the surface crosses it; 0: not.
function crossing(a: number, b: number): number {
  return a < 0 === b < 0 ? 0 : a / (a - b);
}
function one(crossed: number): number {
  return crossed > 0 ? 1 : 0;
}
function side(sample: number): number {
  return sample < 0 ? -0.5 : 0.5;
}
