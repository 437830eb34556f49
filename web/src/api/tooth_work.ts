import { fail, ok, type Result } from "../base/result";
import type { Grid } from "./packed";
import {
  decodeHead,
  decodeSegment,
  decodeStartTooth,
  type FramePose,
  type Head,
  kBrickSamples,
  kBrickSide,
  type OpenSegment,
  type StartTooth,
  StillTooth,
  TimelinePlayer,
} from "./timeline";
import { decodeDeviation } from "./tooth_deviation";
import { coarsened, merged } from "./tooth_coarse";
import { type BlockMesh, kCells, ToothMesher } from "./tooth_mesh";

// The work of playing an attempt back: reads its files and makes triangles of the tooth at any
// moment. It runs in a worker (tooth_worker.ts) and is asked by messages (tooth_link.ts); nothing
// here knows of either, so tests can do without.

// The position of the tooth, for the camera.
export interface Extent {
  readonly centreMm: readonly [number, number, number];
  readonly radiusMm: number;
}

// The vertices of the tooth at its end that were compared with the reference.
export interface Compared {
  readonly positionMm: Float32Array<ArrayBuffer>; // (n x 3)
  readonly normal: Int8Array<ArrayBuffer>; // (n x 4), as a BlockMesh has them
  readonly deviationMm: Float32Array<ArrayBuffer>; // (n)
}

export type ToothAsk =
  | { readonly ask: "head"; readonly id: number; readonly bytes: ArrayBuffer } // the file's beginning
  | { readonly ask: "coarse"; readonly id: number; readonly bytes: ArrayBuffer } // the tooth at its end, until it is there
  | { readonly ask: "start"; readonly id: number; readonly bytes: ArrayBuffer }
  | { readonly ask: "segment"; readonly id: number; readonly index: number; readonly bytes: ArrayBuffer }
  | { readonly ask: "deviation"; readonly id: number; readonly bytes: ArrayBuffer } // after start and last segment
  | { readonly ask: "seek"; readonly frames: number }; // the latest one counts

export type ToothTold =
  | { readonly told: "head"; readonly id: number; readonly head: Result<Head, string> }
  | { readonly told: "coarse"; readonly id: number; readonly extent: Result<Extent, string> }
  | { readonly told: "start"; readonly id: number; readonly extent: Result<Extent, string> }
  | { readonly told: "segment"; readonly id: number; readonly poses: Result<readonly FramePose[], string> }
  | { readonly told: "deviation"; readonly id: number; readonly compared: Result<Compared, string> }
  // What looks otherwise than before; no mesh: no surface passes there. A number below 0 stands for
  // several blocks.
  | { readonly told: "blocks"; readonly blocks: readonly (readonly [number, BlockMesh | undefined])[] }
  // All of it was reported. `cut`: where something went by the end, once that is known.
  | { readonly told: "shown"; readonly frames: number; readonly cut?: Extent | undefined }
  | { readonly told: "failed"; readonly message: string }; // the file is damaged there

// Blocks that stay as they are, to be drawn as one.
interface Still {
  readonly blocks: number[];
  readonly meshes: BlockMesh[];
}

const kSliceMs = 12; // until a later wish is looked for
const kCoarse = -(2 ** 31); // the number of what stands for all blocks
const kTellMs = 100; // until what was made is told; each time is a picture to be drawn

export class ToothWork {
  private head: Head | undefined;
  private player: TimelinePlayer | undefined;
  private mesher: ToothMesher | undefined;
  private readonly early = new Map<number, OpenSegment>(); // segments that came before the start tooth
  private readonly dirty = new Set<number>();
  private fine: Set<number> | undefined; // blocks in all detail; undefined: all, until the end is known
  private coarse = false; // a coarse tooth stands for all of it
  private readonly stills: number[][] = []; // the blocks of each mesh of several; its index is −1 less its place here
  private wanted: number | undefined;
  private working = false;
  private cut: Extent | undefined; // known once the end was sought

  // `pause`: resolves when messages that have come meanwhile were taken.
  constructor(
    private readonly tell: (told: ToothTold, transfer: readonly ArrayBuffer[]) => void,
    private readonly pause: () => Promise<void>,
    private readonly nowMs: () => number = () => performance.now(),
  ) {}

  async take(asked: ToothAsk): Promise<void> {
    switch (asked.ask) {
      case "head":
        return this.tell({ told: "head", id: asked.id, head: await this.readHead(asked.bytes) }, []);
      case "coarse":
        return this.tell({ told: "coarse", id: asked.id, extent: await this.showCoarse(asked.bytes) }, []);
      case "start": {
        const extent = await this.readStart(asked.bytes);
        this.tell({ told: "start", id: asked.id, extent }, []);
        return this.work();
      }
      case "segment": {
        const poses = await this.readSegment(asked.index, asked.bytes);
        this.tell({ told: "segment", id: asked.id, poses }, []);
        return this.work();
      }
      case "deviation": {
        const compared = await this.readDeviation(asked.bytes);
        this.tell(
          { told: "deviation", id: asked.id, compared },
          compared.ok
            ? [compared.value.positionMm.buffer, compared.value.normal.buffer, compared.value.deviationMm.buffer]
            : [],
        );
        return this.work();
      }
      case "seek":
        this.wanted = asked.frames;
        return this.work();
    }
  }

  private async readHead(bytes: ArrayBuffer): Promise<Result<Head, string>> {
    const head = await decodeHead(bytes);
    if (!head.ok) return head;
    if (head.value === undefined) return fail("its head is longer than this page reads");
    this.head = head.value;
    return ok(head.value);
  }

  private async showCoarse(bytes: ArrayBuffer): Promise<Result<Extent, string>> {
    const tooth = await decodeStartTooth(bytes);
    if (!tooth.ok) return tooth;
    // The fine one was faster.
    if (this.player !== undefined) return ok(extentOf(tooth.value));
    const mesher = new ToothMesher(new StillTooth(tooth.value));
    const meshes = mesher.allBlocks().flatMap((block) => mesher.mesh(block) ?? []);
    this.coarse = true;
    this.tellBlocks([[kCoarse, merged(meshes)]]);
    return ok(extentOf(tooth.value));
  }

  private async readStart(bytes: ArrayBuffer): Promise<Result<Extent, string>> {
    const start = await decodeStartTooth(bytes);
    if (!start.ok) return start;
    if (this.head === undefined) return fail("a start tooth came before the head");
    this.player = new TimelinePlayer(this.head, start.value);
    this.mesher = new ToothMesher(this.player);
    for (const [index, segment] of this.early) this.player.add(index, segment);
    this.early.clear();
    for (const block of this.mesher.allBlocks()) this.dirty.add(block);
    return ok(extentOf(start.value));
  }

  private async readSegment(index: number, bytes: ArrayBuffer): Promise<Result<readonly FramePose[], string>> {
    if (this.head === undefined) return fail("a segment came before the head");
    const segment = await decodeSegment(this.head, index, new Uint8Array(bytes));
    if (!segment.ok) return segment;
    if (this.player === undefined) this.early.set(index, segment.value);
    else this.player.add(index, segment.value);
    return ok(segment.value.poses);
  }

  private async readDeviation(bytes: ArrayBuffer): Promise<Result<Compared, string>> {
    const deviation = await decodeDeviation(bytes);
    if (!deviation.ok) return deviation;
    const { player, mesher } = this;
    if (player === undefined || mesher === undefined) return fail("a deviation came before the start tooth");
    const { grid } = player.start;
    if (
      deviation.value.grid.voxelMm !== grid.voxelMm ||
      deviation.value.grid.bricks.some((n, axis) => n !== grid.bricks[axis])
    )
      return fail("the deviation is of another grid");
    mesher.deviation = deviation.value;
    // The blocks that carry it are meshed again for the picture. The figures come from the tooth at
    // its end, whichever moment is shown.
    const blocks = mesher.blocksOf(deviation.value.bricks.keys());
    this.refine(mesher, deviation.value.bricks.keys());
    for (const block of blocks) this.dirty.add(block);
    this.wanted ??= player.frame;
    const compared = await this.compareEnd(player, mesher, blocks);
    return compared;
  }

  private async compareEnd(
    player: TimelinePlayer,
    mesher: ToothMesher,
    blocks: Iterable<number>,
  ): Promise<Result<Compared, string>> {
    const shown = player.frame;
    const there = player.seek(player.head.frames);
    if (!there.ok) return there;
    const found: Compared[] = [];
    for (const block of blocks) {
      const mesh = mesher.mesh(block);
      if (mesh !== undefined) found.push(comparedIn(mesh, mesher.ownVertices()));
    }
    const back = player.seek(shown);
    return back.ok ? ok(joined(found)) : back;
  }

  private async work(): Promise<void> {
    const { player, mesher } = this;
    if (this.working || player === undefined || mesher === undefined) return;
    this.working = true;
    while (this.wanted !== undefined) {
      const frames = Math.max(0, Math.min(this.wanted, player.head.frames));
      const segment = player.segmentOf(frames);
      // Wished for again when that part is here.
      if (segment !== undefined && !player.has(segment)) break;
      this.wanted = undefined;
      const changed = player.seek(frames);
      if (!changed.ok) {
        this.tell({ told: "failed", message: changed.error }, []);
        break;
      }
      if (frames === player.head.frames) this.cut ??= cutOf(player);
      if (frames === player.head.frames)
        this.fine ??= mesher.blocksOf([...player.changed().keys(), ...(mesher.deviation?.bricks.keys() ?? [])]);
      for (const block of mesher.blocksOf(changed.value)) this.dirty.add(block);
      if (!(await this.meshDirty(mesher))) continue;
      this.tell({ told: "shown", frames, cut: this.cut }, []);
    }
    this.working = false;
  }

  // False: overtaken by a later wish. What is left stays dirty and comes first the next time, so
  // that nothing waits for ever.
  private async meshDirty(mesher: ToothMesher): Promise<boolean> {
    let made: [number, BlockMesh | undefined][] = [];
    let still: Still = { blocks: [], meshes: [] };
    const tell = () => {
      const coarse: [number, BlockMesh | undefined][] = this.coarse ? [[kCoarse, undefined]] : [];
      this.coarse = false;
      this.tellBlocks([...coarse, ...made, ...this.keepStill(still)]);
      made = [];
      still = { blocks: [], meshes: [] };
    };
    let until = this.nowMs() + kSliceMs;
    let tellAt = this.nowMs() + kTellMs;
    for (const block of this.dirty) {
      this.dirty.delete(block);
      if (this.fine?.has(block) === false) this.addStill(mesher, block, still);
      else made.push([block, mesher.mesh(block)]);
      if (this.nowMs() < until) continue;
      await this.pause();
      const overtaken = this.wanted !== undefined;
      // The coarse tooth stays until all of the fine one is there.
      if (overtaken || (!this.coarse && this.nowMs() >= tellAt)) {
        tell();
        tellAt = this.nowMs() + kTellMs;
      }
      if (overtaken) return false;
      until = this.nowMs() + kSliceMs;
    }
    tell();
    return true;
  }

  private addStill(mesher: ToothMesher, block: number, { blocks, meshes }: Still): void {
    const mesh = mesher.mesh(block);
    if (mesh === undefined) return;
    blocks.push(block);
    meshes.push(coarsened(mesh, mesher.cells(), kCells));
  }
  private keepStill({ blocks, meshes }: Still): [number, BlockMesh][] {
    if (blocks.length === 0) return [];
    this.stills.push(blocks);
    return [[-this.stills.length, merged(meshes)]];
  }

  // Blocks that change by the end, or have a deviation, get all detail. The rest never changes, so
  // many such blocks become one coarse block. A block that needs detail after all replaces its
  // coarse one at once.
  private refine(mesher: ToothMesher, bricks: Iterable<number>): void {
    const fine = mesher.blocksOf(bricks);
    if (this.fine === undefined) return;
    for (const block of fine) this.fine.add(block);
    this.stills.forEach((blocks, i) => {
      if (!blocks.some((block) => fine.has(block))) return;
      const rest: Still = { blocks: [], meshes: [] };
      const made: [number, BlockMesh | undefined][] = [];
      for (const block of blocks) {
        if (fine.has(block)) made.push([block, mesher.mesh(block)]);
        else this.addStill(mesher, block, rest);
      }
      this.stills[i] = rest.blocks;
      this.tellBlocks([...made, [-1 - i, rest.meshes.length === 0 ? undefined : merged(rest.meshes)]]);
    });
  }

  private tellBlocks(blocks: readonly (readonly [number, BlockMesh | undefined])[]): void {
    if (blocks.length === 0) return;
    const parts = blocks.flatMap(([, mesh]) =>
      mesh === undefined
        ? []
        : [
            mesh.positionMm.buffer,
            mesh.normal.buffer,
            mesh.tissue.buffer,
            mesh.triangle.buffer,
            ...(mesh.deviation === undefined ? [] : [mesh.deviation.buffer]),
          ],
    );
    this.tell({ told: "blocks", blocks }, parts);
  }
}

function comparedIn({ positionMm, normal, deviation }: BlockMesh, vertices: readonly number[]): Compared {
  const own = vertices.filter((vertex) => deviation?.[2 * vertex + 1] === 1);
  return {
    positionMm: Float32Array.from(
      { length: 3 * own.length },
      (_, i) => positionMm[3 * own[Math.floor(i / 3)]! + (i % 3)]!,
    ),
    normal: Int8Array.from({ length: 4 * own.length }, (_, i) => normal[4 * own[i >> 2]! + (i & 3)]!),
    deviationMm: Float32Array.from(own, (vertex) => deviation![2 * vertex]!),
  };
}
function joined(parts: readonly Compared[]): Compared {
  const count = parts.reduce((sum, part) => sum + part.deviationMm.length, 0);
  const out = {
    positionMm: new Float32Array(3 * count),
    normal: new Int8Array(4 * count),
    deviationMm: new Float32Array(count),
  };
  let at = 0;
  for (const part of parts) {
    out.positionMm.set(part.positionMm, 3 * at);
    out.normal.set(part.normal, 4 * at);
    out.deviationMm.set(part.deviationMm, at);
    at += part.deviationMm.length;
  }
  return out;
}

// The ball about the middle of the box around what is solid near the surface.
function extentOf({ grid, slot, samples }: StartTooth): Extent {
  return (
    extent(grid, (each) => {
      for (let b = 0; b < slot.length; ++b) {
        const from = slot[b]!;
        if (from >= 0) eachOf(grid, b, (i) => samples[from * kBrickSamples + i]! < 0, each);
      }
    }) ?? { centreMm: [0, 0, 0], radiusMm: 1 }
  );
}

// The ball around the removed tissue.
function cutOf(player: TimelinePlayer): Extent | undefined {
  return extent(player.start.grid, (each) => {
    for (const [brick, now] of player.changed()) {
      const before = player.startSamples(brick);
      eachOf(
        player.start.grid,
        brick,
        (i) => now[i]! >= 0 && (typeof before === "number" ? before : before[i]!) < 0,
        each,
      );
    }
  });
}

type Each = (x: number, y: number, z: number) => void;

// Of what `all` gives, which is asked twice. Undefined: nothing.
function extent(grid: Grid, all: (each: Each) => void): Extent | undefined {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  all((x, y, z) => {
    if (x < low[0]!) low[0] = x;
    if (y < low[1]!) low[1] = y;
    if (z < low[2]!) low[2] = z;
    if (x > high[0]!) high[0] = x;
    if (y > high[1]!) high[1] = y;
    if (z > high[2]!) high[2] = z;
  });
  if (low[0] === Infinity) return undefined;
  const [cx, cy, cz] = [0, 1, 2].map((axis) => (low[axis]! + high[axis]!) / 2) as [number, number, number];
  let most = 0;
  all((x, y, z) => {
    most = Math.max(most, (x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2);
  });
  const mm = (voxel: number, axis: 0 | 1 | 2) => grid.originMm[axis] + voxel * grid.voxelMm;
  return { centreMm: [mm(cx, 0), mm(cy, 1), mm(cz, 2)], radiusMm: Math.sqrt(most) * grid.voxelMm };
}

// The samples of a brick for which `counts` holds, by their place in the grid.
function eachOf({ bricks: [nx, ny] }: Grid, brick: number, counts: (sample: number) => boolean, each: Each): void {
  const [x, y, z] = [
    (brick % nx) * kBrickSide,
    (Math.floor(brick / nx) % ny) * kBrickSide,
    Math.floor(brick / (nx * ny)) * kBrickSide,
  ];
  for (let i = 0; i < kBrickSamples; ++i) if (counts(i)) each(x + (i & 7), y + ((i >> 3) & 7), z + (i >> 6));
}
