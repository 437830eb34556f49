#include "common/timeline/coarse.h"

#include <algorithm>
#include <vector>

namespace enamel::timeline {
namespace {

using cutting::kBrickSide;
using cutting::kBrickVoxels;

constexpr int kHalves = kBrickSide / kCoarser;  // cubes along a brick's side
constexpr int32_t kCubeSamples = kCoarser * kCoarser * kCoarser;

// Sums of the samples of each cube of kCoarser^3. A distance ends at one voxel, and so a sample of
// it says nothing about a place kCoarser voxels away; the mean over eight cubes does: beside a flat
// surface it falls evenly within kCoarser voxels of it.
class Cubes {
 public:
  explicit Cubes(const Player& player) : n_(player.head().spec.bricks * kHalves) {
    sums_.resize(static_cast<size_t>(n_.x) * static_cast<size_t>(n_.y) * static_cast<size_t>(n_.z));
    const ivec3 bricks = player.head().spec.bricks;
    int brick = 0;
    for (int z = 0; z < bricks.z; ++z)
      for (int y = 0; y < bricks.y; ++y)
        for (int x = 0; x < bricks.x; ++x)
          Add(player.BrickSamples(brick++), ivec3(x, y, z) * kHalves);
  }

  // Of the eight cubes from this one on.
  int8_t Mean(const ivec3& first) const {
    int32_t sum = 0;
    for (int i = 0; i < 8; ++i) sum += At(first + ivec3(i & 1, i >> 1 & 1, i >> 2));
    // Halves go up on both sides of 0, as Quantise does.
    constexpr int32_t kCount = 8 * kCubeSamples;
    const int32_t shifted = sum - kDeep * kCount + kCount / 2;
    return static_cast<int8_t>(std::min<int32_t>(shifted / kCount + kDeep, kFarOut));
  }

 private:
  size_t IndexOf(const ivec3& c) const {
    return (static_cast<size_t>(c.z) * static_cast<size_t>(n_.y) + static_cast<size_t>(c.y)) *
               static_cast<size_t>(n_.x) +
           static_cast<size_t>(c.x);
  }
  int32_t At(const ivec3& c) const {
    if (c.x >= n_.x || c.y >= n_.y || c.z >= n_.z) return kFarOut * kCubeSamples;
    return sums_[IndexOf(c)];
  }
  void Add(const Samples& samples, const ivec3& corner) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      const ivec3 at(i % kBrickSide, i / kBrickSide % kBrickSide, i / kBrickSide / kBrickSide);
      sums_[IndexOf(corner + at / kCoarser)] += samples[static_cast<size_t>(i)];
    }
  }

  ivec3 n_;
  std::vector<int32_t> sums_;
};

// Of the eight voxels around a coarse sample, the first one's that had any: what is solid there is
// of one of them.
uint8_t TissueAround(const Player& player, const ivec3& before) {
  for (int i = 0; i < 8; ++i) {
    const auto tissue = player.TissueAt(before + ivec3(i & 1, i >> 1 & 1, i >> 2));
    if (tissue != cutting::Tissue::kAir) return static_cast<uint8_t>(tissue);
  }
  return 0;
}

void AddBrick(const Player& player, const Cubes& cubes, const ivec3& corner, StartTooth& out) {
  Samples samples;
  cutting::BrickLabels labels{};
  for (int i = 0; i < kBrickVoxels; ++i) {
    const ivec3 at =
        corner + ivec3(i % kBrickSide, i / kBrickSide % kBrickSide, i / kBrickSide / kBrickSide);
    samples[static_cast<size_t>(i)] = cubes.Mean(at);
    labels.tissue[static_cast<size_t>(i)] =
        TissueAround(player, at * kCoarser + ivec3(kCoarser - 1));
  }
  const auto all = [&](int8_t q) {
    return std::ranges::all_of(samples, [q](int8_t sample) { return sample == q; });
  };
  uint8_t flags = 0;
  if (!all(kFarOut)) {
    const uint8_t tissue = labels.tissue[0];
    if (std::ranges::all_of(labels.tissue, [tissue](uint8_t t) { return t == tissue; })) {
      flags = tissue;
    } else {
      flags = StartTooth::kLabelled;
      out.labels.push_back(labels);
    }
    if (!all(kDeep) || flags == 0) {
      flags |= StartTooth::kSampled;
      out.samples.push_back(samples);
    }
  }
  out.bricks.push_back(flags);
}

}  // namespace

Result<StartTooth> CoarseTooth(const Player& player) {
  const cutting::GridSpec& fine = player.head().spec;
  StartTooth out;
  out.spec.voxel_nm = fine.voxel_nm * kCoarser;
  const ivec3 n = fine.bricks * kHalves + ivec3(kBrickSide - 1);
  out.spec.bricks = n / kBrickSide;
  for (size_t axis = 0; axis < 3; ++axis) {
    // In the middle of the first eight cubes.
    out.spec.origin_nm[axis] = fine.origin_nm[axis] + (2 * kCoarser - 1) * fine.voxel_nm / 2;
  }
  ENAMEL_RETURN_IF_ERROR(cutting::ValidateGrid(out.spec));
  const Cubes cubes(player);
  for (int z = 0; z < out.spec.bricks.z; ++z)
    for (int y = 0; y < out.spec.bricks.y; ++y)
      for (int x = 0; x < out.spec.bricks.x; ++x)
        AddBrick(player, cubes, ivec3(x, y, z) * kBrickSide, out);
  return out;
}

}  // namespace enamel::timeline
