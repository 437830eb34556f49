// The samples of a brick, and how they are packed (schemas/surface_timeline.md, "Samples").

export const kBrickSide = 8;
export const kBrickSamples = 512;
export const kDeep = -64;
export const kFarOut = 63;
export const kSteps = 64; // in a voxel

// The steps of all segments but a timeline's last are coarser by so many bits.
export const kCoarse = 2;

// The middle of the samples that a level stands for. The outermost two are exact.
export const fromLevel = (level: number, coarse: number) =>
  level === kDeep >> coarse ? kDeep : level === kFarOut >> coarse ? kFarOut : (level << coarse) + ((1 << coarse) >> 1);

// What a sample would be if the field were flat here, from those before it in the brick at `at`.
export function predicted(s: Int8Array, at: number, i: number): number {
  const x = (i & 7) !== 0;
  const y = (i & 56) !== 0;
  const z = i > 63;
  const n = at + i;
  let p = 0;
  if (x) p += s[n - 1]!;
  if (y) p += s[n - 8]!;
  if (z) p += s[n - 64]!;
  if (x && y) p -= s[n - 9]!;
  if (x && z) p -= s[n - 65]!;
  if (y && z) p -= s[n - 72]!;
  if (x && y && z) p += s[n - 73]!;
  return p < kDeep ? kDeep : p > kFarOut ? kFarOut : p;
}

// In place: an Int8Array keeps a sum modulo 256.
function fromResiduals(s: Int8Array, at: number, coarse: number): void {
  for (let i = 0; i < kBrickSamples; ++i) {
    const n = at + i;
    let p: number;
    if ((i & 7) === 0 || (i & 56) === 0 || i < 64) p = predicted(s, at, i);
    else {
      // Two of three have all their neighbours in the brick: the same, without asking.
      p = s[n - 1]! + s[n - 8]! + s[n - 64]! - s[n - 9]! - s[n - 65]! - s[n - 72]! + s[n - 73]!;
      p = p < kDeep ? kDeep : p > kFarOut ? kFarOut : p;
    }
    s[n] = s[n]! + (p >> coarse);
    if (coarse > 0) s[n] = fromLevel(s[n]!, coarse);
  }
}

// In place, all of them.
export function bricksFromResiduals(samples: Int8Array, coarse = 0): void {
  for (let at = 0; at < samples.length; at += kBrickSamples) fromResiduals(samples, at, coarse);
}
