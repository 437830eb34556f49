#pragma once

#include <cstdint>
#include <span>

#include "common/cutting/profile.h"

// Inner loops of the cutter, eight samples or bricks at a time. Two builds of the same source, for
// any processor and for AVX2; element-wise IEEE operations give the same bits at any width, and
// tests/common/cutting compares the two.
namespace enamel::cutting {

// Samples more than kSolidBandVoxels outside the bur stay unchanged by a cut; samples more than
// kAirBandVoxels inside it become plain air. Two voxels to either side of the new surface are
// enough for its gradient, its mesh and the engagement reading.
inline constexpr float kSolidBandVoxels = 2.0f;
inline constexpr float kAirBandVoxels = 2.5f;

// A bur's outline (profile.h) for the kernels, a number per piece, in voxels; heights count from
// the middle of the body. Single precision: 1e-5 voxel.
struct KernelBur {
  int count = 0;
  struct Piece {
    float first[2], last[2];  // normals
    float at[2], radius;      // arc: centre
    float height;             // line: n . (p - a) = n . p - height
    float region[2][3];       // profile.h
    bool arc, on_axis;        // on_axis: an arc about a point of the axis, part of a ball
  } pieces[Profile::kMaxPieces];
};
KernelBur KernelBurOf(const Bur& bur, double voxel_m) noexcept;

// Affine map from sample indices to the bur frame, in voxels: first + x dx + y dy + z dz; the
// frame's z runs along the bur's axis from the middle of its body.
struct BurFrame {
  float first[3], dx[3], dy[3], dz[3];
};

// Eight bricks in a row along x, to be tested against a pose.
struct CullJob {
  BurFrame frame;  // of the first brick's first sample
  // Where a sample was at the pose that was last cut minus where it is now, same map: what of the
  // bur falls back from a sample cannot change it. Off: every brick is new.
  BurFrame motion;
  bool has_motion;
  float turn;  // bounds |change of motion| over a voxel
  float across,
      along;  // how far a brick's samples are from its middle, across and along the bur's axis
};
// For each brick that may change: which pieces matter in it (bits 0..5) and kCullInside where every
// sample is in the one piece's region. 0 for the others.
struct CullResult {
  int32_t pieces[8];
};
inline constexpr int32_t kCullPasses = 1 << 8, kCullInside = 1 << 9;
// `lowest`: lower bounds of the eight bricks' samples (limit: all air), in samples' units.
using CullKernel = CullResult (*)(const KernelBur& bur, const CullJob& job,
                                  const int16_t* lowest) noexcept;

// Beyond this motion of any point of the bur, in voxels, has_motion must be off.
inline constexpr float kMaxMotion = 2.0f;

struct BrickJob {
  BurFrame frame;  // of the brick's first sample
  int32_t cull;    // CullResult
  int32_t lowest;  // a lower bound of the brick's samples
};
struct BrickChange {
  int32_t lowest =
      0;  // a lower bound of the samples after the cut; exact when no row was out of reach
  int64_t removed = 0;  // 1/65536 voxel
  bool changed = false;
};
// phi := max(phi, -phi_bur) over a brick. `phi`: (8, 8, 8), x fastest, 32-byte aligned. `gone`:
// what went per voxel in 1/8192, aligned alike, or nullptr when the brick has one tissue.
using BrickKernel = BrickChange (*)(const KernelBur& bur, const BrickJob& job, int16_t* phi,
                                    int16_t* gone) noexcept;

// All real-time safe.
struct Kernels {
  CullKernel cull;
  BrickKernel cut;
};
Kernels GenericKernels() noexcept;
// The widest this processor has, unless the environment sets ENAMEL_SIMD=off; decided once.
Kernels BestKernels() noexcept;

}  // namespace enamel::cutting
