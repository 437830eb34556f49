#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/check.h"
#include "common/base/state_archive.h"
#include "common/cutting/brick_kernel.h"
#include "common/cutting/bur.h"
#include "common/cutting/volume.h"

namespace enamel::cutting {

// Solid removed, per tissue, in 1/65536 voxel: integers, so the sum does not depend on order.
using RemovedUnits = std::array<int64_t, kTissueCount>;
inline double RemovedUnitsToM3(int64_t units, double voxel_m) noexcept {
  return static_cast<double>(units) * (voxel_m * voxel_m * voxel_m / 65536.0);
}

// Removes a bur's body from a volume by its absolute pose: phi := max(phi_tooth, -phi_bur). The
// result of a pose does not depend on how often or how slowly it is visited, so removal is exact at
// 0.1 um per tick, and a sweep of poses at most half a voxel apart leaves ridges below
// (h/2)^2 / 8r, 0.3 % of a voxel for r = 0.5 mm at h = 0.05 mm.
//
// Work per call is bounded by the bricks that meet the bur's box plus two voxels: MaxBricks().
// Thread safety: none. Real-time: Cut is safe after Volume::Reserve; the constructor allocates.
class Cutter {
 public:
  // `volume` must outlive the cutter and be changed by nobody else.
  Cutter(Volume& volume, const Bur& bur);

  // Removes the bur at `pose`, adds what went to `removed`. The bricks that changed are in
  // touched() until the next call. False when the volume's reserve was used up (nothing is lost but
  // the cut is incomplete: the caller faults).
  ENAMEL_REALTIME bool Cut(const Pose& pose, RemovedUnits& removed) noexcept;
  std::span<const int32_t> touched() const noexcept { return {touched_.data(), touched_count_}; }
  // False when no solid is within `margin_m` of the bur's bounding sphere: a cheap way to know that
  // a whole move is through open air.
  bool AnySolidNear(const Pose& pose, double margin_m) const noexcept;
  size_t MaxBricks() const noexcept { return touched_.size(); }
  // Saves or restores all that the next Cut depends on but the volume, the bur and its pose. Not
  // real-time.
  void VisitState(StateArchive& archive);

 private:
  bool CutBrick(int brick, const ivec3& first_voxel, const dmat3& scene_from_bur,
                const dvec3& tip_m, RemovedUnits& removed) noexcept;

  Volume& volume_;
  Bur bur_;
  double voxel_m_;
  BrickKernel kernel_;
  std::vector<int16_t> min_phi_;   // per brick: lower bound of its samples, +limit once all air
  std::vector<int32_t> touched_;
  size_t touched_count_ = 0;
};

}  // namespace enamel::cutting
