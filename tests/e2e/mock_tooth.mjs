// A molar-like crown with an occlusal box cavity whose mesial wall was cut 0.3 mm too far, as the
// server's surface format. Made from signed distances, so that the deviation it carries is exact
// near the walls. Frame: millimetres, +x mesial, +y buccal, +z occlusal.

export const kTooDeepMm = 0.3;
const kVoxelMm = 0.14;
const kHalf = [5.9, 5.5, 4.9];
const kEnamelMm = 1.5;
const kBurRadiusMm = 0.5;
const kFloorMm = -0.6;
const kCusps = [[2.5, 2.3, 1.25], [-2.2, 2.5, 1.15], [2.4, -2.5, 1.5], [-2.3, -2.4, 1.4], [-4.0, 0.4, 0.7]];

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

// For who plays it back (mock_timeline.mjs): signed distances in mm, solid below 0.
export const kMockGrid = { voxelMm: kVoxelMm, bricks: kHalf.map((half) => Math.ceil(2 * half / kVoxelMm / 8) + 1), originMm: kHalf.map((half) => -half) };
export function attemptField() {
  return {
    before: crown, cavity: studentCavity, deviation: deviationAt, tissueIn: (mm) => mm > -kEnamelMm ? 1 : 2,
    // The nearest place of the surface at the end, near enough.
    onSurface: (p) => {
      const [mm, along] = [studentSolid(p), gradient(studentSolid, p)];
      return p.map((value, axis) => value - mm * along[axis]);
    },
    // Above this the cavity is cut after a share of the time: down to its floor, sweep by sweep.
    reached: (p, share) => 2.6 - 3.6 * share - p[2],
  };
}

function tissueAt(p) {
  return crown(p) > -kEnamelMm ? 1 : 2;
}

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

// Surface nets: one vertex in each cell the surface crosses, one quad around each crossed edge.
function surfaceNets(f) {
  const size = kHalf.map((half) => Math.ceil((2 * half) / kVoxelMm) + 1);
  const at = (i, j, k) => (k * size[1] + j) * size[0] + i;
  const point = (i, j, k) => [i, j, k].map((n, axis) => -kHalf[axis] + n * kVoxelMm);
  const values = new Float32Array(size[0] * size[1] * size[2]);
  for (let k = 0; k < size[2]; ++k) for (let j = 0; j < size[1]; ++j) for (let i = 0; i < size[0]; ++i) values[at(i, j, k)] = f(point(i, j, k));

  const positions = [];
  const vertexOf = new Map();
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((c) => [c & 1, (c >> 1) & 1, c >> 2]);
  for (let k = 0; k + 1 < size[2]; ++k) for (let j = 0; j + 1 < size[1]; ++j) for (let i = 0; i + 1 < size[0]; ++i) {
    let count = 0;
    const sum = [0, 0, 0];
    for (let a = 0; a < 8; ++a) for (let bit = 1; bit < 8; bit <<= 1) {
      if (a & bit) continue;
      const from = corners[a];
      const to = corners[a | bit];
      const va = values[at(i + from[0], j + from[1], k + from[2])];
      const vb = values[at(i + to[0], j + to[1], k + to[2])];
      if ((va < 0) === (vb < 0)) continue;
      const t = va / (va - vb);
      for (let axis = 0; axis < 3; ++axis) sum[axis] += from[axis] + t * (to[axis] - from[axis]);
      ++count;
    }
    if (count === 0) continue;
    vertexOf.set(at(i, j, k), positions.length);
    positions.push(point(i + sum[0] / count, j + sum[1] / count, k + sum[2] / count));
  }

  const triangles = [];
  const step = [1, size[0], size[0] * size[1]];
  for (let k = 1; k + 1 < size[2]; ++k) for (let j = 1; j + 1 < size[1]; ++j) for (let i = 1; i + 1 < size[0]; ++i) {
    for (let axis = 0; axis < 3; ++axis) {
      const here = at(i, j, k);
      const inside = values[here] < 0;
      if (inside === values[here + step[axis]] < 0) continue;
      const u = step[(axis + 1) % 3];
      const v = step[(axis + 2) % 3];
      const [a, b, c, d] = [here - u - v, here - v, here, here - u].map((cell) => vertexOf.get(cell));
      triangles.push(...(inside ? [[a, b, c], [a, c, d]] : [[a, c, b], [a, d, c]]));
    }
  }
  return { positions, triangles };
}

// ENSF version 1 (schemas/api/openapi.yaml, /attempts/{id}/surface).
// `whole`: before anything is cut.
export function toothSurface({ withDeviation = true, whole = false } = {}) {
  const solid = whole ? crown : studentSolid;
  const { positions, triangles } = surfaceNets(solid);
  const n = positions.length;
  const align4 = (bytes) => (bytes + 3) & ~3;
  const normalAt = align4(32 + 6 * n);
  const tissueAtByte = normalAt + 4 * n;
  const deviationAtByte = align4(tissueAtByte + n);
  const triangleAt = deviationAtByte + (withDeviation ? 4 * n : 0);
  const bytes = Buffer.alloc(triangleAt + 12 * triangles.length);
  const scale = Math.max(...kHalf) * 2 / 65000;
  bytes.write("ENSF", 0, "latin1");
  bytes.writeUInt16LE(1, 4);
  bytes.writeUInt16LE(withDeviation ? 1 : 0, 6);
  bytes.writeUInt32LE(n, 8);
  bytes.writeUInt32LE(triangles.length, 12);
  kHalf.forEach((half, axis) => bytes.writeFloatLE(-half, 16 + 4 * axis));
  bytes.writeFloatLE(scale, 28);
  positions.forEach((p, i) => {
    p.forEach((value, axis) => bytes.writeUInt16LE(Math.round((value + kHalf[axis]) / scale), 32 + 6 * i + 2 * axis));
    gradient(solid, p).forEach((value, axis) => bytes.writeInt8(Math.round(127 * value), normalAt + 4 * i + axis));
    bytes.writeUInt8(tissueAt(p), tissueAtByte + i);
    if (withDeviation) bytes.writeFloatLE(deviationAt(p), deviationAtByte + 4 * i);
  });
  triangles.forEach((triangle, i) => triangle.forEach((index, corner) => bytes.writeUInt32LE(index, triangleAt + 12 * i + 4 * corner)));
  return bytes;
}

// A path of the tool back and forth through the cavity, deeper layer by layer. `share` 0..1.
export function toolPosition(share) {
  const layers = 6;
  const layer = Math.min(layers - 1, Math.floor(share * layers));
  const within = share * layers - layer;
  const sweep = 2 * Math.abs(((within * 7) % 2) - 1) - 1;
  return [sweep * 1.6 + 0.15, -0.8 + 1.6 * within, 1.7 - (layer + 1) * 0.36];
}
