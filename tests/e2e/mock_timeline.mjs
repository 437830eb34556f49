// The attempt of mock_tooth.mjs as it is played back: start tooth, timeline and deviation, written as
// schemas/surface_timeline.md says.
import { createHash } from "node:crypto";
import { deflateSync } from "node:zlib";
import { attemptField, kMockGrid, toolPosition } from "./mock_tooth.mjs";

const kRateHz = 1000;
const kFrameTicks = 100;
const kSegmentFrames = 300;
const { voxelMm, bricks, originMm } = kMockGrid;
const count = bricks[0] * bricks[1] * bricks[2];

const quantised = (mm) => Math.max(-64, Math.min(63, Math.floor(64 * mm / voxelMm)));
const voxelOf = (brick, i) => [brick % bricks[0] * 8 + (i & 7), Math.floor(brick / bricks[0]) % bricks[1] * 8 + (i >> 3 & 7), Math.floor(brick / (bricks[0] * bricks[1])) * 8 + (i >> 6)];
const pointOf = (voxel) => voxel.map((n, axis) => originMm[axis] + n * voxelMm);

function predicted(s, i) {
  const [x, y, z] = [(i & 7) !== 0, (i & 56) !== 0, i > 63];
  const p = (x ? s[i - 1] : 0) + (y ? s[i - 8] : 0) + (z ? s[i - 64] : 0) - (x && y ? s[i - 9] : 0) - (x && z ? s[i - 65] : 0) - (y && z ? s[i - 72] : 0) + (x && y && z ? s[i - 73] : 0);
  return Math.max(-64, Math.min(63, p));
}
const residuals = (s) => Uint8Array.from(s, (q, i) => q - predicted(s, i));

const u32 = (...values) => {
  const out = Buffer.alloc(4 * values.length);
  values.forEach((value, i) => out.writeUInt32LE(value >>> 0, 4 * i));
  return out;
};
function beginning(magic) {
  const out = Buffer.alloc(48);
  out.write(magic, 0, "latin1");
  out.writeUInt16LE(1, 4);
  out.writeInt32LE(Math.round(voxelMm * 1e6), 8);
  bricks.forEach((n, axis) => out.writeInt32LE(n, 12 + 4 * axis));
  originMm.forEach((mm, axis) => out.writeBigInt64LE(BigInt(Math.round(mm * 1e6)), 24 + 8 * axis));
  return out;
}
const blob = (raw) => {
  const packed = deflateSync(Buffer.from(raw));
  return Buffer.concat([u32(packed.length), packed]);
};
const zigzag = (value) => ((value << 1) ^ (value >> 31)) >>> 0;
function planes(values) {
  const out = new Uint8Array(4 * values.length);
  values.forEach((value, i) => { for (let k = 0; k < 4; ++k) out[k * values.length + i] = value >>> (8 * k) & 255; });
  return out;
}
const differences = (values) => values.map((value, i) => zigzag((value - (values[i - 1] ?? 0)) | 0));
function varint(out, value) {
  for (; value >= 128; value >>>= 7) out.push(value & 127 | 128);
  out.push(value);
}

// Distances at every sample, made once: what follows asks for them again and again.
function sampled(f) {
  const out = new Float32Array(count * 512);
  for (let b = 0; b < count; ++b) for (let i = 0; i < 512; ++i) out[512 * b + i] = f(pointOf(voxelOf(b, i)));
  return out;
}
const sampleAt = ([x, y, z]) => 512 * (((z >> 3) * bricks[1] + (y >> 3)) * bricks[0] + (x >> 3)) + (z & 7) * 64 + (y & 7) * 8 + (x & 7);

function startTooth(field, before) {
  const flags = new Uint8Array(count);
  const samples = [];
  const labels = [];
  for (let b = 0; b < count; ++b) {
    const s = Int8Array.from(before.subarray(512 * b, 512 * b + 512), quantised);
    if (s.every((q) => q === 63)) continue;
    flags[b] = 16 | (s.every((q) => q === -64) ? 0 : 8);
    if (flags[b] & 8) samples.push(residuals(s));
    labels.push(Uint8Array.from(before.subarray(512 * b, 512 * b + 512), field.tissueIn));
  }
  return Buffer.concat([beginning("ENTB"), blob(flags), blob(Buffer.concat(samples)), blob(Buffer.concat(labels))]);
}

// Of every brick that is cut at some time: what its samples are at any frame.
function cutBricks(field, whole, box) {
  const out = [];
  for (let b = 0; b < count; ++b) {
    const [before, cavity] = [whole, box].map((all) => all.subarray(512 * b, 512 * b + 512));
    if (!cavity.some((mm, i) => mm < voxelMm && before[i] < voxelMm)) continue;
    const points = Array.from({ length: 512 }, (_, i) => pointOf(voxelOf(b, i)));
    const at = (share) => Int8Array.from(points, (p, i) => quantised(Math.max(before[i], -Math.max(cavity[i], field.reached(p, share)))));
    out.push({ brick: b, at, before: Int8Array.from(before, quantised) });
  }
  return out;
}

function maskedChanges(now, before, masks, values) {
  const state = before.slice();
  const bits = new Uint8Array(64);
  for (let i = 0; i < 512; ++i) if (now[i] !== before[i]) bits[i >> 3] |= 1 << (i & 7);
  masks.push([...Array(8).keys()].reduce((byte, z) => byte | (bits.subarray(8 * z, 8 * z + 8).some((row) => row !== 0) ? 1 << z : 0), 0));
  for (let z = 0; z < 8; ++z) {
    const rows = bits.subarray(8 * z, 8 * z + 8);
    if (rows.every((row) => row === 0)) continue;
    masks.push(rows.reduce((byte, row, y) => byte | (row !== 0 ? 1 << y : 0), 0));
    masks.push(...rows.filter((row) => row !== 0));
  }
  for (let i = 0; i < 512; ++i) {
    if (!(bits[i >> 3] >> (i & 7) & 1)) continue;
    values.push((now[i] - predicted(state, i)) & 255);
    state[i] = now[i];
  }
}

function timeline(cut, start, seconds, pace) {
  const ticks = Math.round(seconds * kRateHz);
  const frames = Math.ceil(ticks / kFrameTicks);
  const now = new Map(cut.map(({ brick, before }) => [brick, before]));
  const index = [];
  const parts = [];
  for (let first = 0; first < frames; first += kSegmentFrames) {
    const n = Math.min(kSegmentFrames, frames - first);
    const share = (k) => ((first + k + 1) / frames) ** pace;
    const tips = Array.from({ length: n }, (_, k) => toolPosition(share(k)).map((mm) => Math.round(mm * 1000)));
    const poses = Buffer.concat([...[0, 1, 2].map((axis) => planes(differences(tips.map((tip) => tip[axis])))),
                                 Buffer.from(new Uint8Array(2 * n)), Buffer.alloc(n, 127), planes(Array(n).fill(0)), Buffer.alloc(n, 1)]);
    const changed = cut.filter(({ brick, before }) => now.get(brick).some((q, i) => q !== before[i]));
    const key = Buffer.concat([u32(...changed.map(({ brick }) => brick)), ...changed.map(({ brick }) => residuals(now.get(brick)))]);
    const [heads, masks, values] = [[], [], []];
    for (let k = 0; k < n; ++k) {
      const moved = cut.map(({ brick, at }) => ({ brick, samples: at(share(k)) })).filter(({ brick, samples }) => samples.some((q, i) => q !== now.get(brick)[i]));
      varint(heads, moved.length);
      moved.forEach(({ brick, samples }, i) => {
        varint(heads, i === 0 ? brick : brick - moved[i - 1].brick - 1);
        maskedChanges(samples, now.get(brick), masks, values);
        now.set(brick, samples);
      });
    }
    const changes = Buffer.concat([u32(heads.length, masks.length), Buffer.from(heads), Buffer.from(masks), Buffer.from(values)]);
    const packed = [poses, key, changes].map((raw) => deflateSync(raw));
    index.push(u32(...packed.map((bytes) => bytes.length), changed.length, changes.length));
    parts.push(...packed);
  }
  const outline = [[0, 0.35], [0.3, 0.5], [3, 0.5], [3.4, 0.8], [12, 0.8]].flat().map((mm) => Math.round(mm * 1e6));
  return Buffer.concat([beginning("ENTL"), createHash("sha256").update(start).digest(), u32(ticks, 0, kRateHz, kFrameTicks, kSegmentFrames, outline.length / 2, index.length),
                        u32(...outline), ...index, ...parts]);
}

function deviation(field, before, cavity) {
  const solid = Uint8Array.from(before, (mm, i) => quantised(Math.max(mm, -cavity[i])) < 0 ? 1 : 0);
  const cells = [];
  const values = [];
  let bricksIn = 0;
  for (let b = 0; b < count; ++b) {
    const mask = Buffer.alloc(64);
    for (let i = 0; i < 512; ++i) {
      const voxel = voxelOf(b, i);
      if (voxel.some((n, axis) => n + 1 >= 8 * bricks[axis])) continue;
      let inside = 0;
      for (let c = 0; c < 8; ++c) inside += solid[sampleAt([voxel[0] + (c & 1), voxel[1] + (c >> 1 & 1), voxel[2] + (c >> 2)])];
      if (inside === 0 || inside === 8) continue;
      const mm = field.deviation(field.onSurface(pointOf(voxel.map((n) => n + 0.5))));
      if (Number.isNaN(mm)) continue;
      mask[i >> 3] |= 1 << (i & 7);
      values.push(Math.round(mm * 1000));
    }
    if (mask.every((byte) => byte === 0)) continue;
    ++bricksIn;
    cells.push(u32(b), mask);
  }
  return Buffer.concat([beginning("ENDV"), u32(bricksIn, values.length), blob(Buffer.concat(cells)), blob(planes(differences(values)))]);
}

const made = new Map();
let base;
// Made once for each pace: all mock servers of a run show the same attempts.
export function mockPlayback(seconds, pace = 1) {
  if (base === undefined) {
    const field = attemptField();
    const [before, cavity] = [sampled(field.before), sampled(field.cavity)];
    base = { start: startTooth(field, before), cut: cutBricks(field, before, cavity), deviation: deviation(field, before, cavity) };
  }
  if (!made.has(pace)) made.set(pace, { ...base, timeline: timeline(base.cut, base.start, seconds, pace) });
  return made.get(pace);
}
