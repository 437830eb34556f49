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
// In the volume's units.
constexpr int16_t PhiOf(int8_t q) { return static_cast<int16_t>((2 * q + 1) * 64); }

Samples QuantiseBrick(const cutting::Volume& volume, int brick);

// The value of a sample if the field were flat here, from the samples before it in the brick.
int Predicted(const Samples& samples, size_t i);

// 512 bytes: each sample less its prediction, modulo 256.
void AppendResiduals(const Samples& samples, Bytes& out);
// Requires: residuals.size() == 512.
Samples FromResiduals(ByteView residuals);

}  // namespace enamel::timeline
