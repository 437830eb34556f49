// A molar-like crown with an occlusal box cavity whose mesial wall was cut 0.3 mm too far, in the
// server's formats for a surface and for a playback. It is made from signed distances, so its
// deviation is exact near the walls. Frame: millimetres, +x mesial, +y buccal, +z occlusal.
import { createHash } from "node:crypto";
import { deflateSync } from "node:zlib";

const kTooDeepMm = 0.3;
const kVoxelMm = 0.14;
const kHalf = [5.9, 5.5, 4.9];
const kEnamelMm = 1.5;
const kBurRadiusMm = 0.5;
const kFloorMm = -0.6;
const kCusps = [
  [2.5, 2.3, 1.25],
  [-2.2, 2.5, 1.15],
  [2.4, -2.5, 1.5],
  [-2.3, -2.4, 1.4],
  [-4.0, 0.4, 0.7],
];

function smoothMax(a, b, k) {
  const h = Math.max(k - Math.abs(a - b), 0) / k;
  return Math.max(a, b) + (h * h * k) / 4;
}

function occlusalHeight(x, y) {
  let z = 1.55;
  for (const [cx, cy, height] of kCusps) z += height * Math.exp(-((x - cx) ** 2 + (y - cy) ** 2) / 2.6);
  z -= 0.35 * Math.exp(-(y * y) / 0.12) * Math.exp(-(x * x) / 14);
  z -= 0.3 * Math.exp(-((x - 0.1) ** 2) / 0.1) * Math.exp(-(y * y) / 9);
  return z - 0.05 * (x * x * 0.6 + y * y * 0.9) * 0.6;
}

function crown([x, y, z]) {
  const waist = 1 - 0.011 * (z - 0.4) ** 2;
  const ring = ((Math.abs(x) / (5.1 * waist)) ** 3 + (Math.abs(y) / (4.7 * waist)) ** 3) ** (1 / 3);
  const side = (ring - 1) * 4.6;
  const top = (z - occlusalHeight(x, y)) * 0.8;
  return smoothMax(smoothMax(side, top, 1.6), -4.1 - z, 0.5);
}

// Distance to the removed box: `mesial` is where its mesial wall stands.
function cavity([x, y, z], mesial, distal, wobble) {
  const centre = (mesial + distal) / 2;
  const half = [(mesial - distal) / 2 - kBurRadiusMm, 1.35 - kBurRadiusMm];
  const dx = Math.abs(x - centre) - half[0];
  const dy = Math.abs(y + 0.05) - half[1];
  const wall = Math.hypot(Math.max(dx, 0), Math.max(dy, 0)) + Math.min(Math.max(dx, dy), 0) - kBurRadiusMm;
  const floor = kFloorMm + wobble * (Math.sin(3.1 * x) * Math.cos(2.3 * y)) - z;
  return smoothMax(wall, floor, 0.12);
}

const kReference = { mesial: 2.1, distal: -2.1 };
const referenceCavity = (p) => cavity(p, kReference.mesial, kReference.distal, 0);
const studentCavity = (p) => cavity(p, kReference.mesial + kTooDeepMm, kReference.distal + 0.09, 0.07);
const studentSolid = (p) => Math.max(crown(p), -studentCavity(p));
const referenceSolid = (p) => Math.max(crown(p), -referenceCavity(p));

// Positive: more removed than in the reference.
function deviationAt(p) {
  const cut = studentCavity(p) < 0.6 * kVoxelMm;
  const shouldBeCut = referenceCavity(p) < 0;
  return cut || shouldBeCut ? -referenceSolid(p) : Number.NaN;
}

const tissueIn = (mm) => (mm > -kEnamelMm ? 1 : 2);

// The nearest place of the surface at the end, near enough.
function onSurface(p) {
  const [mm, along] = [studentSolid(p), gradient(studentSolid, p)];
  return p.map((value, axis) => value - mm * along[axis]);
}

// Above this height the cavity is cut after a share of the time: down to its floor, sweep by sweep.
const reached = (share) => 2.6 - 3.6 * share;

function gradient(f, p) {
  const h = 0.05;
  const g = [0, 1, 2].map((axis) => {
    const plus = [...p];
    const minus = [...p];
    plus[axis] += h;
    minus[axis] -= h;
    return f(plus) - f(minus);
  });
  const length = Math.hypot(...g) || 1;
  return g.map((value) => value / length);
}

// A path of the tool back and forth through the cavity, deeper layer by layer. `share` 0..1.
export function toolPosition(share) {
  const layers = 6;
  const layer = Math.min(layers - 1, Math.floor(share * layers));
  const within = share * layers - layer;
  const sweep = 2 * Math.abs(((within * 7) % 2) - 1) - 1;
  return [sweep * 1.6 + 0.15, -0.8 + 1.6 * within, 1.7 - (layer + 1) * 0.36];
}

// The playback of the attempt: start tooth, timeline and deviation (schemas/surface_timeline.md).

const kRateHz = 1000;
const kFrameTicks = 100;
const kSegmentFrames = 300;
const kChanging = 32;
const bricks = kHalf.map((half) => Math.ceil((2 * half) / kVoxelMm / 8) + 1);
const count = bricks[0] * bricks[1] * bricks[2];

const quantised = (mm) => Math.max(-64, Math.min(63, Math.floor((64 * mm) / kVoxelMm)));
const voxelOf = (brick, i) => [
  (brick % bricks[0]) * 8 + (i & 7),
  (Math.floor(brick / bricks[0]) % bricks[1]) * 8 + ((i >> 3) & 7),
  Math.floor(brick / (bricks[0] * bricks[1])) * 8 + (i >> 6),
];
const pointOf = (voxel) => voxel.map((n, axis) => -kHalf[axis] + n * kVoxelMm);

function predicted(s, i) {
  const [x, y, z] = [(i & 7) !== 0, (i & 56) !== 0, i > 63];
  const p =
    (x ? s[i - 1] : 0) +
    (y ? s[i - 8] : 0) +
    (z ? s[i - 64] : 0) -
    (x && y ? s[i - 9] : 0) -
    (x && z ? s[i - 65] : 0) -
    (y && z ? s[i - 72] : 0) +
    (x && y && z ? s[i - 73] : 0);
  return Math.max(-64, Math.min(63, p));
}
// The middle of the samples that a level of `coarse` bits fewer stands for; the outermost two are exact.
const fromLevel = (level, coarse) =>
  level === -64 >> coarse ? -64 : level === 63 >> coarse ? 63 : (level << coarse) + ((1 << coarse) >> 1);
const coarsened = (s, coarse) => Int8Array.from(s, (q) => fromLevel(q >> coarse, coarse));
const residuals = (s, coarse = 0) => Uint8Array.from(s, (q, i) => (q >> coarse) - (predicted(s, i) >> coarse));

const u32 = (...values) => {
  const out = Buffer.alloc(4 * values.length);
  for (const [i, value] of values.entries()) out.writeUInt32LE(value >>> 0, 4 * i);
  return out;
};
function beginning(magic) {
  const out = Buffer.alloc(48);
  out.write(magic, 0, "latin1");
  out.writeUInt16LE(1, 4);
  out.writeInt32LE(Math.round(kVoxelMm * 1e6), 8);
  for (const axis of [0, 1, 2]) {
    out.writeInt32LE(bricks[axis], 12 + 4 * axis);
    out.writeBigInt64LE(BigInt(Math.round(-kHalf[axis] * 1e6)), 24 + 8 * axis);
  }
  return out;
}
const blob = (raw) => {
  const packed = deflateSync(Buffer.from(raw));
  return Buffer.concat([u32(packed.length), packed]);
};
const zigzag = (value) => ((value << 1) ^ (value >> 31)) >>> 0;
function planes(values) {
  const out = new Uint8Array(4 * values.length);
  values.forEach((value, i) => {
    for (let k = 0; k < 4; ++k) out[k * values.length + i] = (value >>> (8 * k)) & 255;
  });
  return out;
}
const differences = (values) => values.map((value, i) => zigzag((value - (values[i - 1] ?? 0)) | 0));
function varint(out, value) {
  for (; value >= 128; value >>>= 7) out.push((value & 127) | 128);
  out.push(value);
}

// Distances at every sample, made once: what follows asks for them again and again.
function sampled(f) {
  const out = new Float32Array(count * 512);
  for (let b = 0; b < count; ++b) for (let i = 0; i < 512; ++i) out[512 * b + i] = f(pointOf(voxelOf(b, i)));
  return out;
}
const sampleAt = ([x, y, z]) =>
  512 * (((z >> 3) * bricks[1] + (y >> 3)) * bricks[0] + (x >> 3)) + (z & 7) * 64 + (y & 7) * 8 + (x & 7);

function startTooth(before) {
  const flags = new Uint8Array(count);
  const samples = [];
  const labels = [];
  for (let b = 0; b < count; ++b) {
    const s = Int8Array.from(before.subarray(512 * b, 512 * b + 512), quantised);
    if (s.every((q) => q === 63)) continue;
    flags[b] = 16 | (s.every((q) => q === -64) ? 0 : 8);
    if (flags[b] & 8) samples.push(residuals(s));
    labels.push(Uint8Array.from(before.subarray(512 * b, 512 * b + 512), tissueIn));
  }
  return Buffer.concat([beginning("ENTS"), blob(flags), blob(Buffer.concat(samples)), blob(Buffer.concat(labels))]);
}

// All of it may change here: no part of it has triangles of its own.
function changingPart(before) {
  const flags = new Uint8Array(count);
  const samples = [];
  const labels = [];
  for (let b = 0; b < count; ++b) {
    const s = Int8Array.from(before.subarray(512 * b, 512 * b + 512), quantised);
    flags[b] = kChanging;
    if (s.every((q) => q === 63)) continue;
    flags[b] |= 16 | (s.every((q) => q === -64) ? 0 : 8);
    if (flags[b] & 8) samples.push(residuals(s));
    labels.push(Uint8Array.from(before.subarray(512 * b, 512 * b + 512), tissueIn));
  }
  return Buffer.concat([
    u32(count),
    blob(Buffer.concat([planes(Array(count).fill(0)), flags])),
    blob(Buffer.concat(samples)),
    blob(Buffer.concat(labels)),
  ]);
}

// Triangles in strips (schemas/surface_timeline.md, "Meshes"). Each strip is a list of places.
function partMesh(strips, solid) {
  const numbers = new Map();
  const [codes, vertices] = [[], []];
  for (const strip of strips) {
    if (codes.length > 0) codes.push(1);
    for (const place of strip) {
      const name = place.join();
      const known = numbers.get(name);
      codes.push(known === undefined ? 0 : vertices.length - known + 1);
      if (known !== undefined) continue;
      numbers.set(name, vertices.length);
      vertices.push(place);
    }
  }
  const steps = vertices.map((p) => p.map((mm, axis) => Math.round(64 * ((mm + kHalf[axis]) / kVoxelMm + 1))));
  const normals = vertices.map((p) => {
    const n = gradient(solid, p);
    const sum = n.reduce((total, value) => total + Math.abs(value), 0);
    const [x, y, z] = n.map((value) => value / sum);
    const folded = z < 0 ? [(1 - Math.abs(y)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (y < 0 ? -1 : 1)] : [x, y];
    return folded.map((value) => Math.round(127 * value));
  });
  const bytes = (column) => Uint8Array.from(column, (value, i) => value - (column[i - 1] ?? 0));
  return Buffer.concat([
    u32(vertices.length, codes.length),
    blob(Buffer.concat([0, 1, 2].map((axis) => planes(differences(steps.map((place) => place[axis])))))),
    blob(Buffer.concat([0, 1].map((axis) => bytes(normals.map((normal) => normal[axis]))))),
    blob(Uint8Array.from(vertices, (p) => tissueIn(crown(p)))),
    blob(planes(codes)),
  ]);
}

// Of every brick that is cut at some time: what its samples are at any frame.
function cutBricks(whole, box) {
  const out = [];
  for (let b = 0; b < count; ++b) {
    const [before, cavity] = [whole, box].map((all) => all.subarray(512 * b, 512 * b + 512));
    if (!cavity.some((mm, i) => mm < kVoxelMm && before[i] < kVoxelMm)) continue;
    const points = Array.from({ length: 512 }, (_, i) => pointOf(voxelOf(b, i)));
    const [lowest, highest] = [points[0][2] - kVoxelMm, points[511][2] + kVoxelMm];
    let done, samples;
    const at = (share) => {
      const height = Math.min(highest, Math.max(lowest, reached(share))); // beyond these nothing changes
      if (height !== done)
        samples = Int8Array.from(points, ([, , z], i) =>
          quantised(Math.max(before[i], -Math.max(cavity[i], height - z))),
        );
      done = height;
      return samples;
    };
    out.push({ brick: b, at, before: Int8Array.from(before, quantised) });
  }
  return out;
}

// `state` becomes `now`, as a reader has it.
function maskedChanges(now, state, coarse, masks, values) {
  const bits = new Uint8Array(64);
  for (let i = 0; i < 512; ++i) if (now[i] >> coarse !== state[i] >> coarse) bits[i >> 3] |= 1 << (i & 7);
  masks.push(
    [...Array(8).keys()].reduce(
      (byte, z) => byte | (bits.subarray(8 * z, 8 * z + 8).some((row) => row !== 0) ? 1 << z : 0),
      0,
    ),
  );
  for (let z = 0; z < 8; ++z) {
    const rows = bits.subarray(8 * z, 8 * z + 8);
    if (rows.every((row) => row === 0)) continue;
    masks.push(rows.reduce((byte, row, y) => byte | (row !== 0 ? 1 << y : 0), 0));
    masks.push(...rows.filter((row) => row !== 0));
  }
  for (let i = 0; i < 512; ++i) {
    if (!((bits[i >> 3] >> (i & 7)) & 1)) continue;
    values.push(((now[i] >> coarse) - (predicted(state, i) >> coarse)) & 255);
    state[i] = fromLevel(now[i] >> coarse, coarse);
  }
}

// The ball around the samples that were removed by the end.
function cutBall(before, cavity) {
  const removed = [];
  for (let b = 0; b < count; ++b)
    for (let i = 0; i < 512; ++i)
      if (before[512 * b + i] < 0 && cavity[512 * b + i] < 0) removed.push(pointOf(voxelOf(b, i)));
  const of = (pick) => [0, 1, 2].map((axis) => removed.reduce((far, p) => pick(far, p[axis]), removed[0][axis]));
  const [low, high] = [of(Math.min), of(Math.max)];
  const centre = low.map((mm, axis) => (mm + high[axis]) / 2);
  const radius = removed.reduce((far, p) => Math.max(far, Math.hypot(...p.map((mm, axis) => mm - centre[axis]))), 0);
  return [...centre, radius].map((mm) => Math.round(1000 * mm));
}

function timeline({ cut, start, changing, ball }, seconds, pace) {
  const ticks = Math.round(seconds * kRateHz);
  const frames = Math.ceil(ticks / kFrameTicks);
  const now = new Map(cut.map(({ brick, before }) => [brick, before]));
  const index = [];
  const parts = [];
  for (let first = 0; first < frames; first += kSegmentFrames) {
    const n = Math.min(kSegmentFrames, frames - first);
    const share = (k) => ((first + k + 1) / frames) ** pace;
    const tips = Array.from({ length: n }, (_, k) => toolPosition(share(k)).map((mm) => Math.round(mm * 1000)));
    const poses = Buffer.concat([
      ...[0, 1, 2].map((axis) => planes(differences(tips.map((tip) => tip[axis])))),
      Buffer.from(new Uint8Array(2 * n)),
      Buffer.alloc(n, 127),
      planes(Array(n).fill(0)),
      Buffer.alloc(n, 1),
    ]);
    // Steps are coarser before the last segment.
    const coarse = first + n < frames ? 2 : 0;
    const read = new Map(cut.map(({ brick }) => [brick, coarsened(now.get(brick), coarse)]));
    // All that ever changes: then no key frame needs another.
    const key = Buffer.concat([
      u32(...cut.map(({ brick }) => brick)),
      ...cut.map(({ brick }) => residuals(read.get(brick), coarse)),
    ]);
    const [heads, masks, values] = [[], [], []];
    for (let k = 0; k < n; ++k) {
      const moved = cut
        .map(({ brick, at }) => ({ brick, samples: at(share(k)) }))
        .filter(({ brick, samples }) => samples !== now.get(brick) && samples.some((q, i) => q !== now.get(brick)[i]));
      varint(heads, moved.length);
      moved.forEach(({ brick, samples }, i) => {
        varint(heads, i === 0 ? brick : brick - moved[i - 1].brick - 1);
        maskedChanges(samples, read.get(brick), coarse, masks, values);
        now.set(brick, samples);
      });
    }
    const changes = Buffer.concat([
      u32(heads.length, masks.length),
      Buffer.from(heads),
      Buffer.from(masks),
      Buffer.from(values),
    ]);
    const packed = [poses, key, changes].map((raw) => deflateSync(raw));
    index.push(u32(...packed.map((bytes) => bytes.length), cut.length, 0, changes.length));
    parts.unshift(Buffer.concat(packed));
  }
  const outline = [
    [0, 0.35],
    [0.3, 0.5],
    [3, 0.5],
    [3.4, 0.8],
    [12, 0.8],
  ]
    .flat()
    .map((mm) => Math.round(mm * 1e6));
  return Buffer.concat([
    beginning("ENTT"),
    createHash("sha256").update(start).digest(),
    u32(ticks, 0, kRateHz, kFrameTicks, kSegmentFrames, outline.length / 2, index.length),
    u32(...ball, kEnd.length, kStill.length, changing.length),
    u32(...outline),
    ...index,
    kEnd,
    kStill,
    changing,
    ...parts,
  ]);
}

function deviation(before, cavity) {
  const solid = Uint8Array.from(before, (mm, i) => (quantised(Math.max(mm, -cavity[i])) < 0 ? 1 : 0));
  const cells = [];
  const values = [];
  let bricksIn = 0;
  for (let b = 0; b < count; ++b) {
    const mask = Buffer.alloc(64);
    for (let i = 0; i < 512; ++i) {
      const voxel = voxelOf(b, i);
      if (voxel.some((n, axis) => n + 1 >= 8 * bricks[axis])) continue;
      let inside = 0;
      for (let c = 0; c < 8; ++c)
        inside += solid[sampleAt([voxel[0] + (c & 1), voxel[1] + ((c >> 1) & 1), voxel[2] + (c >> 2)])];
      if (inside === 0 || inside === 8) continue;
      const mm = deviationAt(onSurface(pointOf(voxel.map((n) => n + 0.5))));
      if (Number.isNaN(mm)) continue;
      mask[i >> 3] |= 1 << (i & 7);
      values.push(Math.round(mm * 1000));
    }
    if (mask.every((byte) => byte === 0)) continue;
    ++bricksIn;
    cells.push(u32(b), mask);
  }
  return Buffer.concat([
    beginning("ENTD"),
    u32(bricksIn, values.length),
    blob(Buffer.concat(cells)),
    blob(planes(differences(values))),
  ]);
}

const ends = rings(studentSolid, 24, 48);
const kEnd = partMesh(
  ends.slice(1).map((lower, i) => [...lower.keys(), 0].flatMap((j) => [ends[i][j], lower[j]])),
  studentSolid,
);
const kStill = partMesh([], studentSolid);

export const seriesEndS = 43.2;

const made = new Map();
let base;
// Made once for each pace: every flow sees the same attempts.
export function playbackOf(pace = 1) {
  if (base === undefined) {
    const [before, cavity] = [sampled(crown), sampled(studentCavity)];
    base = {
      start: startTooth(before),
      changing: changingPart(before),
      ball: cutBall(before, cavity),
      cut: cutBricks(before, cavity),
      deviation: deviation(before, cavity),
    };
  }
  if (!made.has(pace)) made.set(pace, { ...base, timeline: timeline(base, seriesEndS, pace) });
  return made.get(pace);
}

// Where rays from inside leave the tooth, along meridians from its top: `across` and one rings of `around` places.
function rings(solid, across, around) {
  const inside = [0, 0, -2];
  const along = (i, j) => {
    const [polar, azimuth] = [(Math.PI * i) / across, (2 * Math.PI * j) / around];
    return [Math.sin(polar) * Math.cos(azimuth), Math.sin(polar) * Math.sin(azimuth), Math.cos(polar)];
  };
  const leaving = (direction) => {
    const at = (mm) => inside.map((value, axis) => value + mm * direction[axis]);
    let mm = 0;
    while (solid(at(mm)) < 0) mm += 0.05;
    return at(mm - 0.025);
  };
  return Array.from({ length: across + 1 }, (_, i) => Array.from({ length: around }, (_, j) => leaving(along(i, j))));
}

// The surface as the server's format ENTM (schemas/api/openapi.yaml, /attempts/{id}/surface) without deviation.
function surface(solid) {
  const [across, around] = [64, 128];
  const positions = rings(solid, across, around).flat();
  const triangles = [];
  for (let i = 0; i < across; ++i) {
    for (let j = 0; j < around; ++j) {
      const [a, b, c, d] = [
        [i, j],
        [i + 1, j],
        [i + 1, j + 1],
        [i, j + 1],
      ].map(([row, column]) => row * around + (column % around));
      triangles.push(a, b, c, a, c, d);
    }
  }
  const n = positions.length;
  const scale = (Math.max(...kHalf) * 2) / 65_000;
  const head = Buffer.alloc(32);
  head.write("ENTM", 0, "latin1");
  head.writeUInt16LE(1, 4);
  head.writeUInt32LE(n, 8);
  head.writeUInt32LE(triangles.length / 3, 12);
  for (const [axis, half] of kHalf.entries()) head.writeFloatLE(-half, 16 + 4 * axis);
  head.writeFloatLE(scale, 28);
  const padded = (bytes) => Buffer.concat([bytes, Buffer.alloc(-bytes.length & 3)]);
  return Buffer.concat([
    head,
    padded(
      Buffer.from(
        Uint16Array.from(positions.flatMap((p) => p.map((value, axis) => Math.round((value + kHalf[axis]) / scale))))
          .buffer,
      ),
    ),
    Buffer.from(
      Int8Array.from(positions.flatMap((p) => [...gradient(solid, p).map((value) => Math.round(127 * value)), 0]))
        .buffer,
    ),
    padded(Buffer.from(positions.map((p) => tissueIn(crown(p))))),
    Buffer.from(Uint32Array.from(triangles).buffer),
  ]);
}

const surfaces = new Map();
// `whole`: before anything is cut.
export function toothSurface({ whole = false } = {}) {
  if (!surfaces.has(whole)) surfaces.set(whole, surface(whole ? crown : studentSolid));
  return surfaces.get(whole);
}
