// Which triangle of a surface a ray meets first. The triangles are in a grid of cells, and a ray
// looks only at those of the cells it goes through (Amanatides and Woo, "A fast voxel traversal
// algorithm", 1987; Moeller and Trumbore, 1997): a tooth has most of a million, and a pointer asks
// at every frame. Making the grid is two passes over the triangles.

type Vec = readonly [number, number, number];

export interface Hit {
  readonly triangle: number;
  readonly at: Vec;
}

const kCellsAlong = 96; // of the longest side
const kNone = 1e-12;

export class TriangleGrid {
  private readonly low: [number, number, number] = [Infinity, Infinity, Infinity];
  private readonly count: [number, number, number] = [1, 1, 1];
  private readonly cell: number;
  private readonly first: Uint32Array; // of each cell in `member`; one more at the end
  private readonly member: Uint32Array; // triangles, cell by cell

  // `position`: three numbers for each vertex; `index`: three vertices for each triangle. Both are
  // read later too.
  constructor(
    private readonly position: Float32Array,
    private readonly index: Uint32Array | Uint16Array,
    cellsAlong = kCellsAlong,
  ) {
    const high: [number, number, number] = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < position.length; ++i) {
      const axis = i % 3;
      if (position[i]! < this.low[axis]!) this.low[axis] = position[i]!;
      if (position[i]! > high[axis]!) high[axis] = position[i]!;
    }
    const extent = high.map((value, axis) => Math.max(0, value - this.low[axis]!));
    this.cell = Math.max(...extent, kNone) / cellsAlong;
    for (let axis = 0; axis < 3; ++axis) this.count[axis] = Math.max(1, Math.ceil((extent[axis] ?? 0) / this.cell));
    this.first = new Uint32Array(this.count[0] * this.count[1] * this.count[2] + 1);
    this.eachCell(this.first, undefined, 1);
    for (let cell = 1; cell < this.first.length; ++cell) this.first[cell]! += this.first[cell - 1]!;
    this.member = new Uint32Array(this.first.at(-1) ?? 0);
    this.eachCell(this.first.slice(), this.member, 0);
  }

  // `direction` need not have the length 1. `counts`: whether a place is there at all; what is cut
  // away is not.
  firstHit(origin: Vec, direction: Vec, counts: (at: Vec) => boolean = () => true): Hit | undefined {
    let enter = 0;
    let leave = Infinity;
    for (let axis = 0; axis < 3; ++axis) {
      const [from, way] = [origin[axis]!, direction[axis]!];
      const [a, b] = [this.low[axis]!, this.low[axis]! + this.count[axis]! * this.cell];
      if (Math.abs(way) < kNone) {
        if (from < a || from > b) return undefined;
        continue;
      }
      enter = Math.max(enter, Math.min((a - from) / way, (b - from) / way));
      leave = Math.min(leave, Math.max((a - from) / way, (b - from) / way));
    }
    return enter > leave ? undefined : this.walk(origin, direction, enter, leave, counts);
  }

  private walk(
    origin: Vec,
    direction: Vec,
    enter: number,
    leave: number,
    counts: (at: Vec) => boolean,
  ): Hit | undefined {
    const at: [number, number, number] = [0, 0, 0];
    const step: [number, number, number] = [0, 0, 0];
    const next: [number, number, number] = [Infinity, Infinity, Infinity]; // where the ray crosses into the next cell
    const each: [number, number, number] = [Infinity, Infinity, Infinity];
    for (let axis = 0; axis < 3; ++axis) {
      const way = direction[axis]!;
      at[axis] = this.cellOf(origin[axis]! + enter * way, axis);
      if (Math.abs(way) < kNone) continue;
      step[axis] = Math.sign(way);
      each[axis] = this.cell / Math.abs(way);
      next[axis] = (this.low[axis]! + (at[axis]! + (way > 0 ? 1 : 0)) * this.cell - origin[axis]!) / way;
    }
    for (;;) {
      const axis = next[0] <= next[1] && next[0] <= next[2] ? 0 : next[1] <= next[2] ? 1 : 2;
      // A triangle reaches into several cells: what it is met at beyond this one belongs to a later
      // cell.
      const hit = this.nearestIn(
        (at[2] * this.count[1] + at[1]) * this.count[0] + at[0],
        origin,
        direction,
        Math.min(next[axis], leave),
        counts,
      );
      if (hit !== undefined) return hit;
      at[axis] += step[axis];
      if (next[axis] > leave || at[axis] < 0 || at[axis] >= this.count[axis]) return undefined;
      next[axis] += each[axis];
    }
  }

  private nearestIn(
    cell: number,
    origin: Vec,
    direction: Vec,
    until: number,
    counts: (at: Vec) => boolean,
  ): Hit | undefined {
    const place = (along: number): Vec => [
      origin[0] + along * direction[0],
      origin[1] + along * direction[1],
      origin[2] + along * direction[2],
    ];
    let nearest = until + 1e-6 * (1 + Math.abs(until));
    let found: number | undefined;
    for (let i = this.first[cell]!; i < this.first[cell + 1]!; ++i) {
      const along = this.meets(this.member[i]!, origin, direction);
      if (along === undefined || along > nearest || !counts(place(along))) continue;
      nearest = along;
      found = this.member[i]!;
    }
    return found === undefined ? undefined : { triangle: found, at: place(nearest) };
  }

  // How far along the ray the triangle is met, from either side.
  private meets(triangle: number, [ox, oy, oz]: Vec, [dx, dy, dz]: Vec): number | undefined {
    const { position: p, index } = this;
    const [a, b, c] = [3 * index[3 * triangle]!, 3 * index[3 * triangle + 1]!, 3 * index[3 * triangle + 2]!];
    const [ax, ay, az] = [p[a]!, p[a + 1]!, p[a + 2]!];
    const [ux, uy, uz] = [p[b]! - ax, p[b + 1]! - ay, p[b + 2]! - az];
    const [vx, vy, vz] = [p[c]! - ax, p[c + 1]! - ay, p[c + 2]! - az];
    const [hx, hy, hz] = [dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx];
    const det = ux * hx + uy * hy + uz * hz;
    if (det === 0) return undefined;
    const [sx, sy, sz] = [ox - ax, oy - ay, oz - az];
    const u = (sx * hx + sy * hy + sz * hz) / det;
    if (u < 0 || u > 1) return undefined;
    const [qx, qy, qz] = [sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux];
    const v = (dx * qx + dy * qy + dz * qz) / det;
    if (v < 0 || u + v > 1) return undefined;
    const along = (vx * qx + vy * qy + vz * qz) / det;
    return along >= 0 ? along : undefined;
  }

  private cellOf(value: number, axis: number): number {
    return clamped((value - this.low[axis]!) / this.cell, this.count[axis]!);
  }

  // Counts in `counter` for every cell (`shift` further on) the triangles whose boxes touch it;
  // with `member`, writes the triangle to where the counter stood. Plain loops over plain arrays:
  // this goes twice over most of a million triangles.
  private eachCell(counter: Uint32Array, member: Uint32Array | undefined, shift: number): void {
    const {
      position: p,
      index,
      cell,
      low: [lowX, lowY, lowZ],
      count: [nx, ny, nz],
    } = this;
    const inverse = 1 / cell;
    for (let i = 0, triangle = 0; i < index.length; i += 3, ++triangle) {
      const a = 3 * index[i]!;
      const b = 3 * index[i + 1]!;
      const c = 3 * index[i + 2]!;
      const x0 = clamped((Math.min(p[a]!, p[b]!, p[c]!) - lowX) * inverse, nx);
      const x1 = clamped((Math.max(p[a]!, p[b]!, p[c]!) - lowX) * inverse, nx);
      const y0 = clamped((Math.min(p[a + 1]!, p[b + 1]!, p[c + 1]!) - lowY) * inverse, ny);
      const y1 = clamped((Math.max(p[a + 1]!, p[b + 1]!, p[c + 1]!) - lowY) * inverse, ny);
      const z0 = clamped((Math.min(p[a + 2]!, p[b + 2]!, p[c + 2]!) - lowZ) * inverse, nz);
      const z1 = clamped((Math.max(p[a + 2]!, p[b + 2]!, p[c + 2]!) - lowZ) * inverse, nz);
      for (let z = z0; z <= z1; ++z) {
        for (let y = y0; y <= y1; ++y) {
          for (let x = x0; x <= x1; ++x) {
            const at = (z * ny + y) * nx + x + shift;
            if (member !== undefined) member[counter[at]!] = triangle;
            counter[at]! += 1;
          }
        }
      }
    }
  }
}

function clamped(value: number, count: number): number {
  const whole = Math.floor(value);
  return whole < 0 ? 0 : whole >= count ? count - 1 : whole;
}
