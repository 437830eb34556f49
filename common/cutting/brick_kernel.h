#pragma once

#include <cstdint>

// Inner loop of the cutter: phi := max(phi, -phi_bur) over one brick of 8 x 8 x 8 samples, eight at a
// time. Two builds of the same source, for any processor and for AVX2; element-wise IEEE operations
// give the same bits at any width, and tests/common/cutting compares the two.
namespace enamel::cutting {

// A brick's samples in the bur frame, in voxels: position = first + x dx + y dy + z dz. The frame's
// z runs along the bur's axis from the middle of its body. Single precision: 1e-5 voxel.
struct BrickFrame {
  float first[3], dx[3], dy[3], dz[3];
  float radius, half_length;
  bool sphere;
  int32_t lowest;        // a lower bound of the brick's samples
};

struct BrickChange {
  int32_t lowest = 0;    // a lower bound of the samples after the cut; exact when no row was out of reach
  int64_t removed = 0;   // 1/65536 voxel
  bool changed = false;
};

// `phi`: (8, 8, 8), x fastest, 16-byte aligned. `gone`: what went per voxel, or nullptr when the
// brick has one tissue. Samples over kSolidBandVoxels outside the bur stay as they are, and over
// kAirBandVoxels inside it become plain air: two voxels to either side of the new surface are enough
// for its gradient, its mesh and the engagement reading. Real-time: safe.
inline constexpr float kSolidBandVoxels = 2.0f;
inline constexpr float kAirBandVoxels = 2.5f;
using BrickKernel = BrickChange (*)(const BrickFrame& frame, int16_t* phi, int32_t* gone) noexcept;

BrickChange CutBrickGeneric(const BrickFrame& frame, int16_t* phi, int32_t* gone) noexcept;
// The widest this processor has; decided once.
BrickKernel BestBrickKernel() noexcept;

}  // namespace enamel::cutting
