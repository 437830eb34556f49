import { fail, ok, type Result } from "../base/result";
import { ChangingPart, decodeChanging } from "./changing";
import { type ToothDeviation, decodeDeviation, kNotCompared } from "./deviation";
import { boxBall, comparedIn, joined } from "./film_parts";
import type { Compared, Detail, Extent, FilmAsk, FilmTold, ModelFormat, Plane } from "./messages";
import { type BlockMesh, ToothMesher } from "./mesher";
import { decodeMesh } from "./part_mesh";
import type { Opened, opened, plansOf, savers } from "./opened";
import { decodeSurface, type Surface } from "./surface";
import { kTissues } from "./tissue_color";
import {
  decodeHead,
  decodeSegment,
  framesIn,
  type FramePose,
  type Outline,
  type Head,
  segmentBytes,
  TimelinePlayer,
} from "./timeline";

// A tooth as its screens draw it, block by block: reads its file as it comes, and makes triangles of any moment. Knows
// neither of workers nor of drawing.

// A bur and where it is.
export interface Placed {
  readonly outline: Outline;
  readonly pose: FramePose;
}

export interface FilmScreen {
  // More comes soon: another moment was asked for.
  expect(): void;
  // A part of the tooth; undefined: no surface there.
  setBlock(index: number, mesh: BlockMesh | undefined): void;
  // Undefined: none is shown.
  setBur(bur: Placed | undefined): void;
  // Where the tooth is, and how much of it is there.
  setDetail(detail: Detail, extent: Extent): void;
  // What is inside.
  setOpened(opened: Opened): void;
  // All of a moment is set.
  drawNow(): void;
  // What shines through each block, which stays until it is set again.
  setLooks(looks: (mesh: BlockMesh) => Uint8Array<ArrayBuffer> | undefined): void;
}

export interface FilmOptions {
  // Resolves when messages that have come meanwhile were taken.
  readonly pause: () => Promise<void>;
  // Loads opened.ts.
  readonly opener: () => Promise<{
    readonly opened: typeof opened;
    readonly plansOf: typeof plansOf;
    readonly savers: typeof savers;
  }>;
  readonly nowMs?: () => number;
}

type Deferred = Uint8Array<ArrayBuffer>;

const kSliceMs = 12; // until a later wish is looked for
const kTellMs = 100; // until what was made is drawn; each time is a picture
// Numbers of what is no block of the mesher.
const kStill = -1;
const kEnd = -2; // the changing part at its end, until its blocks are there

export class Film {
  private file = new Uint8Array(0); // what has come and was not read yet
  private filled = 0;
  private reading: Promise<void> = Promise.resolve();
  private steps: Step[] = [{ size: undefined, take: () => this.readHead() }];
  private head: Head | undefined;
  private player: TimelinePlayer | undefined;
  private mesher: ToothMesher | undefined;
  private still: BlockMesh | undefined;
  private inside: Opened | undefined;
  private readonly meshes = new Map<number, BlockMesh>(); // that the screens have
  private readonly looks = new WeakMap<BlockMesh, Uint8Array<ArrayBuffer>>();
  private looking = false;
  private readonly screens = new Set<FilmScreen>();
  private readonly dirty = new Set<number>();
  private readonly tissues = new Set<number>(); // that were seen at the surface
  private detail: Detail = "none";
  private extent: Extent = { centreMm: [0, 0, 0], radiusMm: 1 };
  private shown: number | undefined; // frames
  private wanted: number | undefined; // frames that nobody has begun to make
  private goal = 0; // frames that were asked for last
  private working = false;
  private closed = false;
  private readonly pause: () => Promise<void>;
  private readonly opener: FilmOptions["opener"];
  private readonly nowMs: () => number;

  constructor(
    private readonly tell: (told: FilmTold, transfer: readonly ArrayBuffer[]) => void,
    { pause, opener, nowMs = () => performance.now() }: FilmOptions,
  ) {
    this.pause = pause;
    this.opener = opener;
    this.nowMs = nowMs;
  }

  take(asked: FilmAsk): Promise<void> {
    switch (asked.ask) {
      case "bytes":
        this.keep(new Uint8Array(asked.bytes));
        return this.inTurn(() => this.readMore());
      case "surface":
        return this.inTurn(async () => this.readSurface(asked.bytes));
      case "deviation":
        return this.inTurn(() => this.takeDeviation(asked.bytes));
      case "seek":
        this.want(asked.frames);
        for (const screen of this.screens) screen.expect();
        return this.work();
      case "interior":
        return this.readInterior(asked.bytes);
      case "plans":
        return this.drawPlans(asked.bytes, asked.planes);
      case "model":
        return this.save(asked.as, [...this.meshes.values()]);
      case "close":
        this.closed = true;
        this.screens.clear();
        return Promise.resolve();
    }
  }

  // Gives the screen all there is, and what changes from then on. Returns what ends that.
  attach(screen: FilmScreen): () => void {
    this.screens.add(screen);
    for (const [block, mesh] of this.meshes) screen.setBlock(block, mesh);
    if (this.detail !== "none") screen.setDetail(this.detail, this.extent);
    if (this.inside !== undefined) screen.setOpened(this.inside);
    this.showBur(screen);
    return () => {
      this.screens.delete(screen);
    };
  }

  // One after the other, as they came.
  private inTurn(read: () => Promise<void>): Promise<void> {
    this.reading = this.reading.then(() => (this.closed ? undefined : read()));
    return this.reading;
  }
  private failed(message: string): void {
    this.steps = [];
    this.tell({ told: "failed", message }, []);
  }

  private keep(bytes: Uint8Array): void {
    if (this.filled + bytes.length > this.file.length) {
      const more = new Uint8Array(Math.max(2 * this.file.length, this.filled + bytes.length));
      more.set(this.file.subarray(0, this.filled));
      this.file = more;
    }
    this.file.set(bytes, this.filled);
    this.filled += bytes.length;
  }
  private drop(size: number): Deferred {
    const taken = this.file.slice(0, size);
    this.file.copyWithin(0, size, this.filled);
    this.filled -= size;
    return taken;
  }

  private async readMore(): Promise<void> {
    for (;;) {
      const step = this.steps[0];
      if (step === undefined) return;
      if (step.size !== undefined && this.filled < step.size) return;
      const bytes = step.size === undefined ? undefined : this.drop(step.size);
      const done = await step.take(bytes);
      if (this.closed) return;
      if (!done.ok) return this.failed(done.error);
      if (!done.value) return; // needs more bytes
      this.steps.shift();
    }
  }

  private async readHead(): Promise<Result<boolean, string>> {
    const head = await decodeHead(this.file.slice(0, this.filled).buffer);
    if (!head.ok) return head;
    if (head.value === undefined) return ok(false);
    const file = head.value;
    this.head = file;
    this.drop(file.bytes);
    this.tell({ told: "head", head: file }, []);
    let end: BlockMesh | undefined;
    const step = (size: number, take: (bytes: Deferred) => Promise<Result<unknown, string>>): Step => ({
      size,
      take: async (bytes) => {
        const done = await take(bytes!);
        return done.ok ? ok(true) : done;
      },
    });
    this.steps.push(
      step(file.endBytes, async (bytes) => {
        const mesh = await decodeMesh(bytes, file.grid);
        if (mesh.ok) end = mesh.value;
        return mesh;
      }),
      step(file.stillBytes, async (bytes) => {
        const mesh = await decodeMesh(bytes, file.grid);
        if (mesh.ok) this.showCoarse(mesh.value, end!);
        return mesh;
      }),
      step(file.changingBytes, async (bytes) => {
        const bricks = await decodeChanging(bytes, file.grid);
        if (bricks.ok) {
          this.player = new TimelinePlayer(file, new ChangingPart(bricks.value));
          this.mesher = new ToothMesher(this.player);
          for (const block of this.mesher.allBlocks()) this.dirty.add(block);
          if (file.segments.length === 0) this.ready();
        }
        return bricks;
      }),
      ...[...file.segments.keys()].reverse().map((index) =>
        step(segmentBytes(file.segments[index]!), async (bytes) => {
          const segment = await decodeSegment(file, index, bytes);
          if (!segment.ok) return segment;
          this.player?.add(index, segment.value);
          const ticks = Uint32Array.from({ length: framesIn(file, index) }, (_, i) => segment.value.poses[i]!.gapTicks);
          this.tell({ told: "gaps", segment: index, ticks }, [ticks.buffer]);
          if (index === file.segments.length - 1) this.ready();
          if (index === 0) this.tell({ told: "whole" }, []);
          // A moment may have been asked for that is here now.
          void this.work();
          await this.pause();
          return segment;
        }),
      ),
    );
    if (file.segments.length === 0) this.steps.push({ size: 0, take: async () => this.wholeAtOnce() });
    return ok(true);
  }
  private wholeAtOnce(): Result<boolean, string> {
    this.tell({ told: "whole" }, []);
    return ok(true);
  }
  private ready(): void {
    this.tell({ told: "ready" }, []);
    if (this.wanted === undefined) this.want(this.head?.frames ?? 0);
    void this.work();
  }
  private want(frames: number): void {
    this.wanted = this.goal = frames;
  }

  private showCoarse(still: BlockMesh, end: BlockMesh): void {
    this.still = still;
    this.extent = boxBall([still.positionMm, end.positionMm]) ?? this.extent;
    this.setBlocks([
      [kStill, still],
      [kEnd, end],
    ]);
    this.become("coarse");
  }
  private become(detail: Detail): void {
    this.detail = detail;
    for (const screen of this.screens) screen.setDetail(detail, this.extent);
    for (const screen of this.screens) screen.drawNow();
    this.tell({ told: "detail", detail, extent: this.extent, tissues: this.seen() }, []);
  }
  private seen(): number[] {
    return [...this.tissues].sort((a, b) => a - b);
  }

  private async readSurface(bytes: ArrayBuffer): Promise<void> {
    const surface = decodeSurface(bytes);
    if (!surface.ok) return this.failed(surface.error);
    const { positionMm, normal, tissue, triangle, deviationMm } = surface.value;
    this.extent = boxBall([positionMm]) ?? this.extent;
    this.setBlocks([
      [kStill, { positionMm, normal, tissue, triangle, deviation: pairsOf(surface.value) } as BlockMesh],
    ]);
    this.become("fine");
    const compared =
      deviationMm === undefined
        ? undefined
        : { positionMm: positionMm.slice(), normal: normal.slice(), deviationMm: deviationMm.slice() };
    this.tell({ told: "compared", compared: ok(compared) }, []);
  }

  private open<T>(use: (script: Awaited<ReturnType<FilmOptions["opener"]>>) => T) {
    return this.opener().then(use, () => fail("what reads it could not be loaded"));
  }
  private async save(as: ModelFormat, meshes: readonly BlockMesh[]): Promise<void> {
    const model = await this.open(({ savers }) => ok(savers[as](meshes)));
    this.tell({ told: "model", model }, model.ok ? [model.value] : []);
  }
  private async drawPlans(bytes: ArrayBuffer, planes: readonly Plane[]): Promise<void> {
    this.tell({ told: "plans", plans: await this.open(({ plansOf }) => plansOf(bytes, planes)) }, []);
  }
  private async readInterior(bytes: ArrayBuffer): Promise<void> {
    const made = await this.open(({ opened }) => opened(bytes));
    if (this.closed) return;
    if (made.ok) {
      this.inside = made.value;
      for (const screen of this.screens) screen.setOpened(made.value);
      void this.rest();
    }
    this.tell({ told: "interior", tissues: made.ok ? ok(made.value.tissues) : made }, []);
  }

  private async takeDeviation(bytes: ArrayBuffer): Promise<void> {
    const compared = await this.readDeviation(bytes);
    this.tell(
      { told: "compared", compared },
      compared.ok
        ? [compared.value.positionMm, compared.value.normal, compared.value.deviationMm].map(
            (part) => part.buffer as ArrayBuffer,
          )
        : [],
    );
    return this.work();
  }

  private async readDeviation(bytes: ArrayBuffer): Promise<Result<Compared, string>> {
    const deviation = await decodeDeviation(bytes);
    if (!deviation.ok) return deviation;
    const { player, mesher } = this;
    if (player === undefined || mesher === undefined) return fail("a deviation came before the tooth");
    const { grid } = player.head;
    const its = deviation.value.grid;
    if (its.voxelMm !== grid.voxelMm || its.bricks.some((n, axis) => n !== grid.bricks[axis]))
      return fail("the deviation is of another grid");
    mesher.deviation = deviation.value;
    const blocks = mesher.blocksOf(deviation.value.bricks.keys());
    this.wanted = this.goal;
    const compared = this.compareEnd(player, mesher, blocks);
    const still = this.stillCompared(deviation.value);
    return compared.ok ? ok(still === undefined ? compared.value : joined([compared.value, still])) : compared;
  }

  // The figures come from the tooth at its end, whichever moment is shown. The blocks that carry the deviation are
  // meshed again for the picture, unless it shows the end.
  private compareEnd(player: TimelinePlayer, mesher: ToothMesher, blocks: Iterable<number>): Result<Compared, string> {
    const before = player.frame;
    const there = player.seek(player.head.frames);
    if (!there.ok) return there;
    const found: Compared[] = [];
    const atEnd = before === player.head.frames;
    for (const block of blocks) {
      const mesh = mesher.mesh(block);
      if (mesh !== undefined) found.push(comparedIn(mesh, mesher.ownVertices()));
      if (atEnd && !this.dirty.has(block)) this.setBlocks([[block, mesh]]);
      else this.dirty.add(block);
    }
    const back = player.seek(before);
    return back.ok ? ok(joined(found)) : back;
  }

  // A score with another reference may know more cells than the timeline has kept in detail. Their vertices are few.
  private stillCompared({ bricks }: ToothDeviation): Compared | undefined {
    const { still, head } = this;
    if (still === undefined || head === undefined) return undefined;
    const { grid } = head;
    const [nx, ny] = grid.bricks;
    const deviation = new Float32Array(2 * still.tissue.length);
    for (let v = 0; v < still.tissue.length; ++v) {
      const [x, y, z] = [0, 1, 2].map((axis) =>
        Math.floor((still.positionMm[3 * v + axis]! - grid.originMm[axis as 0 | 1 | 2]) / grid.voxelMm),
      ) as [number, number, number];
      if (x < 0 || y < 0 || z < 0) continue;
      const um = bricks.get(((z >> 3) * ny + (y >> 3)) * nx + (x >> 3))?.[(z & 7) * 64 + (y & 7) * 8 + (x & 7)];
      if (um !== undefined && um !== kNotCompared) deviation.set([um / 1000, 1], 2 * v);
    }
    // On the border between both parts the changing one has the same vertices.
    const own = [...still.tissue.keys()].filter((v) => deviation[2 * v + 1] === 1 && !this.isListed(v, still));
    if (own.length === 0) return undefined;
    this.still = { ...still, deviation };
    this.setBlocks([[kStill, this.still]]);
    return comparedIn(this.still, own);
  }
  private isListed(vertex: number, { positionMm }: BlockMesh): boolean {
    const { head, player } = this;
    if (head === undefined || player === undefined) return false;
    const { grid } = head;
    const [bx, by, bz] = [0, 1, 2].map((axis) =>
      Math.floor((positionMm[3 * vertex + axis]! - grid.originMm[axis as 0 | 1 | 2]) / grid.voxelMm / 8),
    ) as [number, number, number];
    return player.bricks.flags[(bz * grid.bricks[1] + by) * grid.bricks[0] + bx] !== 0;
  }

  // Nothing moves: what shines through the surface has its time. A moment that is asked for meanwhile goes before it.
  async rest(): Promise<void> {
    const { inside } = this;
    if (inside === undefined || this.detail !== "fine" || this.looking) return;
    this.looking = true;
    let until = this.nowMs() + kSliceMs;
    for (const mesh of this.meshes.values()) {
      if (this.looks.has(mesh)) continue;
      this.looks.set(mesh, inside.looksOf(mesh));
      if (this.nowMs() < until) continue;
      await this.pause();
      if (this.closed || this.working) break;
      until = this.nowMs() + kSliceMs;
    }
    this.looking = false;
    if (this.working || this.closed) return;
    // A moment that came and was done within a pause has other blocks: without theirs it would be a patchwork.
    if ([...this.meshes.values()].some((mesh) => !this.looks.has(mesh))) return this.rest();
    for (const screen of this.screens) screen.setLooks((mesh) => this.looks.get(mesh));
  }

  private async work(): Promise<void> {
    const { player, mesher } = this;
    if (this.working || this.closed || player === undefined || mesher === undefined) return;
    this.working = true;
    while (this.wanted !== undefined && !this.closed) {
      const frames = Math.max(0, Math.min(this.wanted, player.head.frames));
      const segment = player.segmentOf(frames);
      // Wished for again when that part is here.
      if (segment !== undefined && !player.has(segment)) break;
      this.wanted = undefined;
      const changed = player.seek(frames);
      if (!changed.ok) {
        this.failed(changed.error);
        break;
      }
      for (const block of mesher.blocksOf(changed.value)) this.dirty.add(block);
      if (await this.meshDirty(mesher)) this.show(frames);
    }
    this.working = false;
  }
  private show(frames: number): void {
    this.shown = frames;
    for (const screen of this.screens) this.showBur(screen);
    if (this.detail === "fine") for (const screen of this.screens) screen.drawNow();
    else this.become("fine");
    this.tell({ told: "shown", frames, tissues: this.seen() }, []);
  }
  // At the end there is none.
  private showBur(screen: FilmScreen): void {
    const { head, shown } = this;
    screen.setBur(this.burAt(head !== undefined && shown !== undefined && shown < head.frames ? shown : undefined));
  }
  // Undefined: there is none, or it is not here yet.
  burAt(frames: number | undefined): Placed | undefined {
    const pose = frames === undefined ? undefined : this.player?.pose(frames);
    const outline = this.head?.outlines[pose?.bur ?? 0];
    return pose === undefined || outline === undefined ? undefined : { outline, pose };
  }

  // False: overtaken by a later wish. What is left stays dirty and comes first the next time, so that nothing waits
  // for ever.
  private async meshDirty(mesher: ToothMesher): Promise<boolean> {
    let made: [number, BlockMesh | undefined][] = [];
    const give = () => {
      // The coarse one stays until all of the fine one is there.
      if (this.detail !== "fine" && this.dirty.size > 0) return;
      this.setBlocks(this.meshes.has(kEnd) ? [[kEnd, undefined], ...made] : made);
      made = [];
    };
    let until = this.nowMs() + kSliceMs;
    let giveAt = this.nowMs() + kTellMs;
    for (const block of this.dirty) {
      this.dirty.delete(block);
      made.push([block, mesher.mesh(block)]);
      if (this.nowMs() < until) continue;
      await this.pause();
      if (this.closed) return false;
      const overtaken = this.wanted !== undefined;
      if (overtaken || this.nowMs() >= giveAt) {
        give();
        giveAt = this.nowMs() + kTellMs;
      }
      if (overtaken) {
        for (const [block] of made) this.dirty.add(block);
        return false;
      }
      until = this.nowMs() + kSliceMs;
    }
    give();
    return true;
  }

  private setBlocks(blocks: readonly (readonly [number, BlockMesh | undefined])[]): void {
    let seen = 0; // a bit for each tissue
    for (const [block, mesh] of blocks) {
      if (mesh === undefined) this.meshes.delete(block);
      else this.meshes.set(block, mesh);
      for (const tissue of mesh?.tissue ?? []) seen |= 1 << tissue;
      for (const screen of this.screens) screen.setBlock(block, mesh);
    }
    for (let tissue = 0; tissue < kTissues; ++tissue) if ((seen >> tissue) & 1) this.tissues.add(tissue);
  }
}

// Of a file: so many bytes, and what reads them. Undefined: as many as there are.
interface Step {
  readonly size: number | undefined;
  // False: it needs more bytes.
  readonly take: (bytes: Deferred | undefined) => Promise<Result<boolean, string>>;
}

// (deviation or 0, 1 where compared): interpolated, x / y is the deviation right up to the border of what was cut,
// where NaN would eat a row of triangles.
function pairsOf({ tissue, deviationMm }: Surface): Float32Array<ArrayBuffer> | undefined {
  if (deviationMm === undefined) return undefined;
  const pairs = new Float32Array(2 * tissue.length);
  deviationMm.forEach((value, i) => {
    if (!Number.isNaN(value)) pairs.set([value, 1], 2 * i);
  });
  return pairs;
}
