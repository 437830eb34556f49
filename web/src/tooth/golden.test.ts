// The golden tooth of schemas/surface_timeline.md, for the tests of this folder.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import type { Result } from "../base/result";
import { type Bricks, ChangingPart, decodeChanging } from "./changing";
import { decodeHead, decodeSegment, type Head, segmentBytes, TimelinePlayer } from "./timeline";

export const golden = (name: string) =>
  new Uint8Array(readFileSync(`../schemas/golden/surface_timeline.${name}`)).buffer;

export function value<T>(result: Result<T, string>): T {
  assert.ok(result.ok, result.ok ? "" : result.error);
  return result.value;
}

export async function goldenHead(): Promise<Head> {
  return value(await decodeHead(golden("entl")))!;
}

// Bytes of a part of the file.
export async function goldenPart(part: "end" | "still" | "changing"): Promise<Uint8Array<ArrayBuffer>> {
  const { bytes, endBytes, stillBytes, changingBytes } = await goldenHead();
  const from = bytes + (part === "end" ? 0 : part === "still" ? endBytes : endBytes + stillBytes);
  const size = part === "end" ? endBytes : part === "still" ? stillBytes : changingBytes;
  return new Uint8Array(golden("entl").slice(from, from + size));
}
export function segmentOf({ segments }: Head, index: number): ArrayBuffer {
  const segment = segments[index]!;
  return golden("entl").slice(segment.from, segment.from + segmentBytes(segment));
}

// What the document says of the sample after so many frames.
export function expectedSample(x: number, y: number, z: number, frames: number): number {
  let d = Math.sqrt((x - 19.5) ** 2 + (y - 19.5) ** 2 + (z - 19.5) ** 2) - 14.3;
  for (let j = 0; j < frames; ++j)
    d = Math.max(d, 4 - Math.sqrt((x - 19.5) ** 2 + (y - 19.5) ** 2 + (z - (34 - 1.5 * j)) ** 2));
  return Math.max(-64, Math.min(63, Math.floor(64 * d)));
}
export const sampleAt = (brick: number, i: number) =>
  [
    (brick % 5) * 8 + (i & 7),
    (Math.floor(brick / 5) % 5) * 8 + ((i >> 3) & 7),
    Math.floor(brick / 25) * 8 + (i >> 6),
  ] as const;
export const isDentin = (x: number, y: number, z: number) =>
  Math.sqrt((x - 19.5) ** 2 + (y - 19.5) ** 2 + (z - 19.5) ** 2) < 9;

async function withSegments(bricks: Bricks): Promise<TimelinePlayer> {
  const head = await goldenHead();
  const player = new TimelinePlayer(head, new ChangingPart(bricks));
  for (const i of head.segments.keys())
    player.add(i, value(await decodeSegment(head, i, new Uint8Array(segmentOf(head, i)))));
  return player;
}
export async function goldenPlayer(): Promise<TimelinePlayer> {
  const { grid } = await goldenHead();
  return withSegments(value(await decodeChanging(await goldenPart("changing"), grid)));
}
// The same tooth, of which every brick may change.
export async function wholePlayer(): Promise<TimelinePlayer> {
  const { grid } = await goldenHead();
  const all = Array.from({ length: 125 * 512 }, (_, i) => sampleAt(i >> 9, i & 511));
  return withSegments({
    grid,
    flags: new Uint8Array(125).fill(32 | 16 | 8),
    samples: Int8Array.from(all, ([x, y, z]) => expectedSample(x, y, z, 0)),
    slot: Int32Array.from({ length: 125 }, (_, b) => b),
    labels: Uint8Array.from(all, (place) => (isDentin(...place) ? 2 : 1)),
    labelSlot: Int32Array.from({ length: 125 }, (_, b) => b),
    changing: Uint32Array.from({ length: 125 }, (_, b) => b),
  });
}
