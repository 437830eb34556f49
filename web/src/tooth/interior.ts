import { kBrickSamples, kBrickSide } from "./samples";
import type { Result } from "../base/result";
import { Broken, checkMagic, kFormatBytes, type Grid, inflate, readGrid, reading, sectionsOf } from "./packed";
import { kTissues } from "./tissue_color";

// The tissue at each place of a tooth, also where no surface passes: of a start tooth ("ENTS"), version 1
// (schemas/surface_timeline.md, "Start tooth"), all but its samples.

const kTissue = 7;
const kLabelled = 16;
const kKnown = kTissue | 8 | kLabelled;
const kAir = 0;

export interface Interior {
  readonly grid: Grid;
  readonly flags: Uint8Array; // of each brick
  readonly labels: Uint8Array; // 512 of each labelled brick
  readonly labelSlot: Int32Array; // per brick: its place in `labels`, or −1
}

export function decodeInterior(bytes: ArrayBuffer): Promise<Result<Interior, string>> {
  return reading(async () => {
    const view = new DataView(bytes);
    checkMagic(view, "ENTS", "start tooth");
    const grid = readGrid(view);
    const count = grid.bricks[0] * grid.bricks[1] * grid.bricks[2];
    const [packedFlags, , packedLabels] = sectionsOf(new Uint8Array(bytes), kFormatBytes, 3, "a start tooth");
    const flags = await inflate(packedFlags!, count, "bricks");
    if (flags.some((own) => own & ~kKnown)) throw new Broken("a brick has flags that this page does not know");
    const labelSlot = new Int32Array(count).fill(-1);
    let labelled = 0;
    for (let brick = 0; brick < count; ++brick) if (flags[brick]! & kLabelled) labelSlot[brick] = labelled++;
    const labels = await inflate(packedLabels!, labelled * kBrickSamples, "labels");
    if (labels.some((tissue) => tissue >= kTissues)) throw new Broken("a label is no tissue");
    return { grid, flags, labels, labelSlot };
  });
}

// Those that are somewhere in it.
export function tissuesIn({ flags, labels }: Interior): number[] {
  let seen = 0; // a bit for each tissue
  for (const own of flags) if (!(own & kLabelled)) seen |= 1 << (own & kTissue);
  for (const tissue of labels) seen |= 1 << tissue;
  return Array.from({ length: kTissues }, (_, tissue) => tissue).filter(
    (tissue) => tissue !== kAir && (seen >> tissue) & 1,
  );
}

// 0: air, or outside the grid. Triangles are off by up to a voxel from the samples, so a place in a voxel of air next to
// a tissue is in that tissue.
export function tissueAt(interior: Interior, x: number, y: number, z: number): number {
  const [i, j, k] = voxelOf(interior.grid, x, y, z);
  return (
    voxel(interior, i, j, k) ||
    voxel(interior, i - 1, j, k) ||
    voxel(interior, i + 1, j, k) ||
    voxel(interior, i, j - 1, k) ||
    voxel(interior, i, j + 1, k) ||
    voxel(interior, i, j, k - 1) ||
    voxel(interior, i, j, k + 1)
  );
}
// The same of the voxel alone.
export function voxelAt(interior: Interior, x: number, y: number, z: number): number {
  const [i, j, k] = voxelOf(interior.grid, x, y, z);
  return voxel(interior, i, j, k);
}
function voxelOf({ voxelMm, originMm }: Grid, x: number, y: number, z: number): readonly [number, number, number] {
  return [
    Math.round((x - originMm[0]) / voxelMm),
    Math.round((y - originMm[1]) / voxelMm),
    Math.round((z - originMm[2]) / voxelMm),
  ];
}

// −1: outside the grid.
export function brickAt({ grid }: Interior, x: number, y: number, z: number): number {
  return brickOf(grid, ...voxelOf(grid, x, y, z));
}
function brickOf({ bricks }: Grid, i: number, j: number, k: number): number {
  const [x, y, z] = [i >> 3, j >> 3, k >> 3];
  if (x < 0 || y < 0 || z < 0 || x >= bricks[0] || y >= bricks[1] || z >= bricks[2]) return -1;
  return (z * bricks[1] + y) * bricks[0] + x;
}

function voxel({ grid, flags, labels, labelSlot }: Interior, i: number, j: number, k: number): number {
  const brick = brickOf(grid, i, j, k);
  if (brick < 0) return kAir;
  const slot = labelSlot[brick]!;
  return slot < 0 ? flags[brick]! & kTissue : labels[slot * kBrickSamples + (k & 7) * 64 + (j & 7) * 8 + (i & 7)]!;
}

// Which bricks have a tissue in them or so near: 1.
export function bricksNear(interior: Interior, tissue: number, reachMm: number): Uint8Array {
  const { grid, flags, labels, labelSlot } = interior;
  const near = new Uint8Array(flags.length);
  const [nx, ny, nz] = grid.bricks;
  const reach = Math.ceil(reachMm / (kBrickSide * grid.voxelMm));
  for (let brick = 0; brick < flags.length; ++brick) {
    const from = labelSlot[brick]! * kBrickSamples;
    const has =
      from < 0 ? (flags[brick]! & kTissue) === tissue : labels.subarray(from, from + kBrickSamples).includes(tissue);
    if (!has) continue;
    const [x, y, z] = [brick % nx, Math.floor(brick / nx) % ny, Math.floor(brick / (nx * ny))];
    for (let k = Math.max(0, z - reach); k <= Math.min(nz - 1, z + reach); ++k)
      for (let j = Math.max(0, y - reach); j <= Math.min(ny - 1, y + reach); ++j)
        for (let i = Math.max(0, x - reach); i <= Math.min(nx - 1, x + reach); ++i) near[(k * ny + j) * nx + i] = 1;
  }
  return near;
}
