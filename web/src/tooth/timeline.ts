import { fail, ok, type Result } from "../base/result";
import { ChangingPart } from "./changing";
import type { Extent } from "./places";
import {
  Broken,
  checkMagic,
  fromPlanes,
  kFormatBytes,
  type Grid,
  inflate,
  readGrid,
  reading,
  unzigzag,
} from "./packed";
import { bricksFromResiduals, fromLevel, kBrickSamples, kCoarse, predicted } from "./samples";

// Reads what plays an attempt back: a surface timeline ("ENTT"), version 1 (schemas/surface_timeline.md). Nothing here
// draws or fetches.

const kHeadBytes = 136;
const kAsAtStart = 2 ** 31; // in a key frame, beside a brick's number

type Read<T> = Result<T, string>;

export interface Segment {
  readonly from: number; // first byte in the file
  readonly poseBytes: number;
  readonly keyBytes: number;
  readonly changeBytes: number;
  readonly keyBricks: number;
  readonly keyStart: number; // of them, still as at the start
  readonly changeSize: number;
}

export interface Head {
  readonly grid: Grid;
  readonly start: string; // SHA-256 of the start tooth's file, hexadecimal
  readonly ticks: number;
  readonly rateHz: number;
  readonly frameTicks: number;
  readonly segmentFrames: number;
  readonly frames: number;
  readonly cut: Extent | undefined; // the ball around what was removed by the end
  readonly endBytes: number;
  readonly stillBytes: number;
  readonly changingBytes: number;
  readonly outlines: readonly Outline[]; // of each bur
  readonly segments: readonly Segment[];
  readonly bytes: number; // of the head itself
  readonly endsAt: number; // so many bytes of the file show the tooth at its end
  readonly fileBytes: number;
}

// mm: place along the axis, radius.
export type Outline = ReadonlyArray<readonly [number, number]>;

export interface FramePose {
  readonly tipMm: readonly [number, number, number];
  readonly axis: readonly [number, number, number]; // toward the shank, unit
  readonly turning: boolean;
  readonly bur: number; // which of the outlines
  readonly gapTicks: number;
}

// A segment while it is read: its changes are applied frame by frame.
export interface OpenSegment {
  readonly poses: readonly FramePose[];
  readonly keyBricks: Uint32Array;
  readonly keySamples: Int8Array;
  readonly changes: Uint8Array;
}

function between(what: string, value: number, least: number, most: number): number {
  if (value < least || value > most)
    throw new Broken(`timeline: expected ${what} from ${least} to ${most}, found ${value}`);
  return value;
}

// Of a file that begins with `start`; `undefined` as value: the head is not all there.
export async function decodeHead(start: ArrayBuffer): Promise<Read<Head | undefined>> {
  return reading(() => {
    const view = new DataView(start);
    if (start.byteLength < kFormatBytes) return undefined;
    checkMagic(view, "ENTT", "timeline");
    const grid = readGrid(view);
    if (start.byteLength < kHeadBytes) return undefined;
    const hash = Array.from(new Uint8Array(start, 48, 32), (byte) => byte.toString(16).padStart(2, "0")).join("");
    const rateHz = between("a rate in Hz", view.getUint32(88, true), 1, 1e6);
    const frameTicks = between("ticks of a frame", view.getUint32(92, true), 1, 1e6);
    const segmentFrames = between("frames of a segment", view.getUint32(96, true), 1, 1e5);
    const ticks = between("ticks", Number(view.getBigUint64(80, true)), 0, 12e6 * frameTicks);
    const frames = Math.ceil(ticks / frameTicks);
    const points = between("points of an outline", view.getUint32(100, true), 0, 256);
    const segmentCount = Math.ceil(frames / segmentFrames);
    between("segments", view.getUint32(104, true), segmentCount, segmentCount);
    between("segments", segmentCount, 0, 65_536);
    const bytes = kHeadBytes + 8 * points + 24 * segmentCount;
    const mm = (at: number) => view.getInt32(at, true) / 1000;
    const radiusMm = mm(120);
    if (radiusMm < 0) throw new Broken("timeline: the radius of what was removed is below 0");
    const [endBytes, stillBytes, changingBytes] = [0, 1, 2].map((i) => view.getUint32(124 + 4 * i, true)) as [
      number,
      number,
      number,
    ];
    if (start.byteLength < bytes) return undefined;
    const outlines: [number, number][][] = [];
    for (let i = 0; i < points; ++i) {
      const [place, radius] = [0, 4].map((at) => view.getInt32(kHeadBytes + 8 * i + at, true) * 1e-6) as [
        number,
        number,
      ];
      // A bur's only point there.
      if (place === 0) outlines.push([]);
      outlines.at(-1)?.push([place, radius]);
    }
    const sizes = Array.from({ length: segmentCount }, (_, i) => {
      const at = kHeadBytes + 8 * points + 24 * i;
      const [poseBytes, keyBytes, changeBytes] = [
        view.getUint32(at, true),
        view.getUint32(at + 4, true),
        view.getUint32(at + 8, true),
      ];
      return {
        poseBytes,
        keyBytes,
        changeBytes,
        keyBricks: view.getUint32(at + 12, true),
        keyStart: view.getUint32(at + 16, true),
        changeSize: view.getUint32(at + 20, true),
      };
    });
    // The last one comes first.
    let from = bytes + endBytes + stillBytes + changingBytes;
    let endsAt = from;
    const segments: Segment[] = [];
    for (const size of sizes.reverse()) {
      segments.unshift({ ...size, from });
      from += size.poseBytes + size.keyBytes + size.changeBytes;
      if (segments.length === 1) endsAt = from;
    }
    return {
      grid,
      start: hash,
      ticks,
      rateHz,
      frameTicks,
      segmentFrames,
      frames,
      cut: radiusMm === 0 ? undefined : { centreMm: [mm(108), mm(112), mm(116)], radiusMm },
      endBytes,
      stillBytes,
      changingBytes,
      outlines,
      segments,
      bytes,
      endsAt,
      fileBytes: from,
    };
  });
}

// What a page needs to ask for a segment.
export const segmentBytes = ({ poseBytes, keyBytes, changeBytes }: Segment) => poseBytes + keyBytes + changeBytes;

export function framesIn(head: Head, segment: number): number {
  return Math.min(head.segmentFrames, head.frames - segment * head.segmentFrames);
}

// A moment before the last segment is for a look at how it came about.
const coarseIn = (head: Head, segment: number) => (segment < head.segments.length - 1 ? kCoarse : 0);

// `bytes`: the segment's own, all of them.
export function decodeSegment(head: Head, index: number, bytes: Uint8Array<ArrayBuffer>): Promise<Read<OpenSegment>> {
  return reading(async () => {
    const segment = head.segments[index]!;
    if (bytes.length !== segmentBytes(segment))
      throw new Broken(`segment ${index}: expected ${segmentBytes(segment)} bytes, found ${bytes.length}`);
    const part = (from: number, size: number) => bytes.subarray(from, from + size);
    const n = framesIn(head, index);
    const poses = await inflate(part(0, segment.poseBytes), 20 * n, "poses");
    const key = await inflate(
      part(segment.poseBytes, segment.keyBytes),
      4 * segment.keyBricks + kBrickSamples * (segment.keyBricks - segment.keyStart),
      "key frame",
    );
    const changes = await inflate(
      part(segment.poseBytes + segment.keyBytes, segment.changeBytes),
      segment.changeSize,
      "changes",
    );
    const keyView = new DataView(key.buffer);
    const keyBricks = Uint32Array.from({ length: segment.keyBricks }, (_, i) => keyView.getUint32(4 * i, true));
    const count = head.grid.bricks[0] * head.grid.bricks[1] * head.grid.bricks[2];
    const numberOf = (i: number) => keyBricks[i]! % kAsAtStart;
    keyBricks.forEach((_, i) => {
      if (numberOf(i) >= count || (i > 0 && numberOf(i) <= numberOf(i - 1)))
        throw new Broken(`brick ${numberOf(i)} is out of order or outside the grid`);
    });
    if (keyBricks.filter((entry) => entry >= kAsAtStart).length !== segment.keyStart)
      throw new Broken(`segment ${index}: another number of bricks is as at the start`);
    const keySamples = new Int8Array(key.buffer, 4 * segment.keyBricks);
    bricksFromResiduals(keySamples, coarseIn(head, index));
    return { poses: readPoses(poses, n), keyBricks, keySamples, changes };
  });
}

function readPoses(raw: Uint8Array, n: number): FramePose[] {
  const tip = [0, 1, 2].map((axis) => {
    let before = 0;
    return Array.from({ length: n }, (_, i) => {
      before = (before + unzigzag(fromPlanes(raw, 4 * n * axis, n, i))) | 0;
      return before / 1000;
    });
  });
  const signed = new Int8Array(raw.buffer, raw.byteOffset);
  return Array.from({ length: n }, (_, i) => {
    const axis = [0, 1, 2].map((a) => signed[12 * n + a * n + i]! / 127);
    const tool = raw[19 * n + i]!;
    return {
      tipMm: [tip[0]![i]!, tip[1]![i]!, tip[2]![i]!],
      axis: [axis[0]!, axis[1]!, axis[2]!],
      turning: tool % 2 === 1,
      bur: tool >> 1,
      gapTicks: fromPlanes(raw, 15 * n, n, i),
    };
  });
}

// The tooth at any frame. Segments are given as they come; seek says which it needs.
export class TimelinePlayer extends ChangingPart {
  private readonly segments = new Map<number, OpenSegment>();
  private readonly count: number;
  private current = new Map<number, Int8Array>(); // bricks that are not the start's
  private entered = -1; // segment whose changes are open
  private at = 0; // frames applied
  private heads = 0;
  private headsEnd = 0;
  private masks = 0;
  private masksEnd = 0;
  private values = 0;

  constructor(
    readonly head: Head,
    part: ChangingPart,
  ) {
    super(part.bricks);
    this.count = head.grid.bricks[0] * head.grid.bricks[1] * head.grid.bricks[2];
  }

  get frame(): number {
    return this.at;
  }
  add(index: number, segment: OpenSegment): void {
    this.segments.set(index, segment);
  }
  has(index: number): boolean {
    return this.segments.has(index);
  }
  // The segment that the tooth after so many frames is read from; undefined: none, it is the start.
  segmentOf(frames: number): number | undefined {
    return frames === 0 ? undefined : Math.floor((frames - 1) / this.head.segmentFrames);
  }
  pose(frames: number): FramePose | undefined {
    const index = this.segmentOf(Math.max(frames, 1)) ?? 0;
    return this.segments.get(index)?.poses[Math.max(frames, 1) - 1 - index * this.head.segmentFrames];
  }

  // The tooth after so many frames. Returns the bricks that look otherwise than before. Needs: the
  // segment was added, and all after it.
  seek(frames: number): Read<Set<number>> {
    const before = this.current;
    try {
      const index = this.segmentOf(frames);
      if (index === undefined) {
        this.current = new Map();
        this.entered = -1;
        this.at = 0;
        return ok(this.differing(before));
      }
      const segment = this.segments.get(index);
      if (segment === undefined) return fail("this part of the playback is not here yet");
      if (this.entered === index && this.at <= frames) {
        const changed = new Set<number>();
        while (this.at < frames) this.applyFrame(segment.changes, changed);
        return ok(changed);
      }
      this.enter(index, segment);
      while (this.at < frames) this.applyFrame(segment.changes, undefined);
      return ok(this.differing(before));
    } catch (error) {
      if (!(error instanceof Broken)) throw error;
      this.entered = -1;
      return fail(error.message);
    }
  }

  // Bricks that may look otherwise than at the start, with their samples.
  changed(): ReadonlyMap<number, Int8Array> {
    return this.current;
  }

  override samples(brick: number): Int8Array | number {
    return this.current.get(brick) ?? this.startSamples(brick);
  }

  private differing(before: Map<number, Int8Array>): Set<number> {
    const out = new Set<number>();
    const look = (brick: number, was: Int8Array | undefined) => {
      const now = this.samples(brick);
      const then = was ?? this.startSamples(brick);
      for (let i = 0; i < kBrickSamples; ++i) {
        if ((typeof now === "number" ? now : now[i]) === (typeof then === "number" ? then : then[i])) continue;
        out.add(brick);
        return;
      }
    };
    for (const [brick, was] of before) look(brick, was);
    for (const brick of this.current.keys()) if (!before.has(brick)) look(brick, undefined);
    return out;
  }

  private enter(index: number, segment: OpenSegment): void {
    this.current = new Map();
    // The nearest key frame that has a brick knows it. Those after a segment came before it.
    const last = this.head.segments.length - 1;
    for (let left = last - index; ; left &= left - 1) {
      const { keyBricks, keySamples } = this.segments.get(last - left)!;
      let at = 0;
      for (const entry of keyBricks) {
        const brick = entry % kAsAtStart;
        const from = at;
        if (entry < kAsAtStart) at += kBrickSamples;
        if (this.current.has(brick)) continue;
        if (entry < kAsAtStart) this.current.set(brick, keySamples.slice(from, at));
        else this.ownSamples(brick);
      }
      if (left === 0) break;
    }
    const { changes } = segment;
    if (changes.length < 8) throw new Broken(`the changes of segment ${index} end early`);
    const view = new DataView(changes.buffer, changes.byteOffset, changes.length);
    this.heads = 8;
    this.headsEnd = this.masks = 8 + view.getUint32(0, true);
    this.masksEnd = this.values = this.masks + view.getUint32(4, true);
    if (this.values > changes.length) throw new Broken(`the changes of segment ${index} end early`);
    this.entered = index;
    this.at = index * this.head.segmentFrames;
  }

  private varint(changes: Uint8Array): number {
    let value = 0;
    for (let scale = 1; scale < 2 ** 42; scale *= 128) {
      if (this.heads >= this.headsEnd) break;
      const byte = changes[this.heads++]!;
      value += (byte & 127) * scale;
      if (byte < 128) return value;
    }
    throw new Broken(`the changes of frame ${this.at} end early`);
  }
  private mask(changes: Uint8Array): number {
    if (this.masks >= this.masksEnd) throw new Broken(`the changes of frame ${this.at} end early`);
    return changes[this.masks++]!;
  }

  private applyFrame(changes: Uint8Array, changed: Set<number> | undefined): void {
    const bricks = this.varint(changes);
    let brick = -1;
    for (let i = 0; i < bricks; ++i) {
      brick += 1 + this.varint(changes);
      if (brick >= this.count) throw new Broken("a changed brick is outside the grid");
      changed?.add(brick);
      this.applyBrick(brick, changes);
    }
    ++this.at;
  }

  private applyBrick(brick: number, changes: Uint8Array): void {
    const state = this.ownSamples(brick);
    const coarse = coarseIn(this.head, this.entered);
    const layers = this.mask(changes);
    for (let z = 0; z < 8; ++z) {
      if (!((layers >> z) & 1)) continue;
      const rows = this.mask(changes);
      for (let y = 0; y < 8; ++y) {
        if (!((rows >> y) & 1)) continue;
        const bits = this.mask(changes);
        for (let x = 0; x < 8; ++x) {
          if (!((bits >> x) & 1)) continue;
          if (this.values >= changes.length) throw new Broken("a brick's changes end early");
          const i = z * 64 + y * 8 + x;
          state[i] = changes[this.values++]! + (predicted(state, 0, i) >> coarse);
          state[i] = fromLevel(state[i]!, coarse);
        }
      }
    }
  }
  private ownSamples(brick: number): Int8Array {
    const own = this.current.get(brick);
    if (own !== undefined) return own;
    const now = this.samples(brick);
    const made = typeof now === "number" ? new Int8Array(kBrickSamples).fill(now) : now.slice();
    this.current.set(brick, made);
    return made;
  }
}
