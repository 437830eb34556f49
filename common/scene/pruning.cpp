#include "common/scene/pruning.h"

#include <algorithm>
#include <functional>
#include <span>

#include "common/base/check.h"
#include "common/scene/builder.h"

namespace enamel::scene {
namespace {

using cutting::BrickPhi;
using cutting::GridSpec;
using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::kPhiLimit;
using cutting::Tissue;
using cutting::Volume;

// Chosen. A bur that leaves it meets air where a tooth was: forces differ there, and only there.
constexpr int64_t kMargin_nm = 2'000'000;

template <typename Array, typename Value>
bool AllAre(const Array& values, Value value) {
  return std::all_of(values.begin(), values.end(), [&](auto v) { return v == value; });
}

void CopyTight(const Volume& from, int brick, Volume& to) {
  if (!from.IsStored(brick)) return CopyBrick(from, brick, to);
  const auto& phi = from.Phi(brick).phi;
  bool labelled =
      from.HasLabels(brick) && !AllAre(from.Labels(brick).tissue, from.Labels(brick).tissue[0]);
  if (labelled) return CopyBrick(from, brick, to);
  Tissue tissue = from.HasLabels(brick) ? static_cast<Tissue>(from.Labels(brick).tissue[0])
                                        : from.UniformTissue(brick);
  // Air is what a volume begins as.
  if (AllAre(phi, kPhiLimit)) return;
  if (AllAre(phi, static_cast<int16_t>(-kPhiLimit))) return to.SetUniform(brick, tissue);
  to.SetBrick(brick, phi, {}, tissue);
}

Volume EachBrick(const Volume& from, const std::function<void(const ivec3&, int, Volume&)>& copy) {
  const GridSpec& spec = from.spec();
  Volume out(spec);
  for (int z = 0; z < spec.bricks.z; ++z)
    for (int y = 0; y < spec.bricks.y; ++y)
      for (int x = 0; x < spec.bricks.x; ++x) copy({x, y, z}, spec.BrickIndex({x, y, z}), out);
  return out;
}

// With the voxel around, as samples between bricks read the neighbours.
bool Touches(const Reach& reach, const GridSpec& spec, const ivec3& brick) {
  for (int i = 0; i < 3; ++i) {
    auto axis = static_cast<size_t>(i);
    int64_t lo = spec.origin_nm[axis] + (int64_t{brick[i]} * kBrickSide - 1) * spec.voxel_nm;
    int64_t hi = lo + int64_t{kBrickSide + 2} * spec.voxel_nm;
    // Upward without end: the bur comes from there.
    if (hi < reach.lo_nm[axis] || (i < 2 && lo > reach.hi_nm[axis])) return false;
  }
  return true;
}

}  // namespace

Reach ReachOf(const Scene& scene, const Exercise& exercise) {
  const CavityTarget& t = exercise.target;
  const PointUm& at = scene.landmarks.at(t.landmark);
  int64_t side = int64_t{t.leeway_side_um} + t.container_um;
  int32_t widest_um = 0;
  for (const BurSpec& bur : exercise.burs()) widest_um = std::max(widest_um, bur.radius_um);
  side += widest_um;
  int64_t bottom = int64_t{t.depth_um} + t.leeway_bottom_um + t.container_um;
  Reach reach;
  for (size_t i = 0; i < 2; ++i) {
    reach.lo_nm[i] = (at[i] - t.half_size_um[i] - side) * 1000 - kMargin_nm;
    reach.hi_nm[i] = (at[i] + t.half_size_um[i] + side) * 1000 + kMargin_nm;
  }
  reach.lo_nm[2] = (at[2] - bottom) * 1000 - kMargin_nm;
  reach.hi_nm[2] = at[2] * int64_t{1000};
  return reach;
}

Volume Pruned(const Volume& volume, const Reach& reach) {
  return EachBrick(volume, [&](const ivec3& at, int brick, Volume& out) {
    if (Touches(reach, volume.spec(), at)) CopyTight(volume, brick, out);
  });
}

Volume Pruned(const Volume& volume) {
  return EachBrick(volume,
                   [&](const ivec3&, int brick, Volume& out) { CopyTight(volume, brick, out); });
}

Volume Unpruned(const Volume& volume) {
  return EachBrick(volume, [&](const ivec3&, int brick, Volume& out) {
    BrickPhi phi;
    std::array<uint8_t, kBrickVoxels> labels;
    Tissue tissue = volume.UniformTissue(brick);
    if (volume.IsStored(brick)) {
      phi = volume.Phi(brick);
    } else {
      phi.phi.fill(tissue == Tissue::kAir ? kPhiLimit : static_cast<int16_t>(-kPhiLimit));
    }
    if (volume.HasLabels(brick)) {
      labels = volume.Labels(brick).tissue;
    } else {
      labels.fill(static_cast<uint8_t>(tissue == Tissue::kAir ? Tissue::kGypsum : tissue));
    }
    out.SetBrick(brick, phi.phi, labels, static_cast<Tissue>(labels[0]));
  });
}

Volume Without(const Volume& volume, Tissue tissue) {
  return EachBrick(volume, [&](const ivec3&, int brick, Volume& out) {
    bool only = volume.HasLabels(brick)
                    ? AllAre(volume.Labels(brick).tissue, static_cast<uint8_t>(tissue))
                    : volume.UniformTissue(brick) == tissue;
    if (!only) CopyTight(volume, brick, out);
  });
}

}  // namespace enamel::scene
