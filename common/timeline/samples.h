#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "common/base/bytes.h"
#include "common/cutting/volume.h"

// A brick's distances in 8 bits, and how they are packed (schemas/surface_timeline.md).
// Thread safety: functions, any thread.
namespace enamel::timeline {

// (8, 8, 8), x fastest. q stands for a distance of (2 q + 1) / 128 voxel: negative is solid, as in
// the volume, and nearer than a voxel it is off by at most 1/128 voxel. Farther ones are all the
// same: an edge that the surface crosses has no end farther away.
using Samples = std::array<int8_t, cutting::kBrickVoxels>;
inline constexpr int8_t kDeep = -64, kFarOut = 63;  // a voxel or more inside, outside

constexpr int8_t Quantise(int phi) {
  const int q = phi >> 7;
  return static_cast<int8_t>(q < kDeep ? kDeep : q > kFarOut ? kFarOut : q);
}
// Steps of a sample in so many bits fewer: what a level stands for, in the middle of its samples. The
// outermost two stay what they are, and solid stays solid.
constexpr int8_t FromLevel(int level, int coarse) {
  if (level == kDeep >> coarse) return kDeep;
  if (level == kFarOut >> coarse) return kFarOut;
  return static_cast<int8_t>((level << coarse) + ((1 << coarse) >> 1));
}
// Of the samples of all segments but a timeline's last: 1/16 voxel.
inline constexpr int kCoarse = 2;
Samples Coarsened(const Samples& samples, int coarse);

// In the volume's units.
constexpr int16_t PhiOf(int8_t q) { return static_cast<int16_t>((2 * q + 1) * 64); }

Samples QuantiseBrick(const cutting::Volume& volume, int brick);

// The value of a sample if the field were flat here, from the samples before it in the brick.
int Predicted(const Samples& samples, size_t i);

// A sample's level less that of its prediction, modulo 256.
constexpr uint8_t Residual(int8_t sample, int predicted, int coarse) {
  return static_cast<uint8_t>((sample >> coarse) - (predicted >> coarse));
}
constexpr int8_t FromResidual(uint8_t residual, int predicted, int coarse) {
  return FromLevel(static_cast<int8_t>(residual + (predicted >> coarse)), coarse);
}

// 512 bytes: each sample's residual. Requires: samples == Coarsened(samples, coarse).
void AppendResiduals(const Samples& samples, Bytes& out, int coarse = 0);
// Requires: residuals.size() == 512.
Samples FromResiduals(ByteView residuals, int coarse = 0);

}  // namespace enamel::timeline
