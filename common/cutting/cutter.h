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
// 0.1 um per tick, and a sweep of poses at most s apart leaves ridges below s^2 / 8r,
// 0.3 % of a voxel for s = 25 um, r = 0.5 mm, h = 0.05 mm. A sharp edge that moves along the axis
// of a bur with a slanting side leaves s times the side's slope: 4 um for an inverted cone that
// plunges, r 0.6 to 0.4 x 1.2 mm.
//
// Only bricks that can change are visited: those within the band of the new surface, not yet air,
// and where the bur has moved outward since the pose that was last cut (brick_kernel.h). That pose
// is state: two cutters at the same volume with different last poses may differ by 1/8192 voxel of
// rounding.
//
// Work per call is bounded by the bricks that meet the bur's box plus two voxels: MaxBricks().
// Thread safety: none. Real-time: Cut is safe after Volume::Reserve; the constructor allocates.
class Cutter {
 public:
  // `volume` must outlive the cutter and be changed by nobody else. It begins with the first bur.
  // Requires: burs is not empty.
  Cutter(Volume& volume, std::span<const Bur> burs);
  Cutter(Volume& volume, const Bur& bur) : Cutter(volume, std::span(&bur, 1)) {}

  // Cuts with another of its burs from now on. Requires: bur < burs.size(), and no half of a cut waits.
  ENAMEL_REALTIME void Use(size_t bur) noexcept;

  // Removes the bur at `pose`, adds what went to `removed`. The bricks that changed are in
  // touched() until the next call. False when the volume's reserve was used up (nothing is lost but
  // the cut is incomplete: the caller faults).
  ENAMEL_REALTIME bool Cut(const Pose& pose, RemovedUnits& removed) noexcept;
  // The same in two halves of about equal work, so that a tick need not do all of it: the lower
  // brick layers of the bur's box, then, at the same pose and before any other cut, the upper ones.
  // The volume is that of Cut once both are done.
  ENAMEL_REALTIME bool CutLower(const Pose& pose, RemovedUnits& removed) noexcept;
  ENAMEL_REALTIME bool CutUpper(const Pose& pose, RemovedUnits& removed) noexcept;
  std::span<const int32_t> touched() const noexcept { return {touched_.data(), touched_count_}; }
  // False when no solid is within `margin_m` of the bur's box, shank included: a cheap way to know
  // that a whole move is through open air.
  bool AnySolidNear(const Pose& pose, double margin_m) const noexcept;
  // The one in use.
  const Bur& bur() const noexcept { return burs_[in_use_].bur; }
  size_t MaxBricks() const noexcept { return touched_.size(); }

  // Saves or restores all that the next Cut depends on but the volume, the bur in use and its pose. Not
  // real-time.
  void VisitState(StateArchive& archive);

 private:
  struct Placed;  // A pose with what a cut needs of it.

  Placed Place(const Pose& pose) const noexcept;
  bool CutLayers(const Pose& pose, bool lower, bool upper, RemovedUnits& removed) noexcept;
  void CutBrick(int brick, const BrickJob& job, RemovedUnits& removed) noexcept;

  struct Prepared {
    Bur bur;
    KernelBur kernel;
  };

  Volume& volume_;
  double voxel_m_;
  Kernels kernels_;
  std::vector<Prepared> burs_;
  size_t in_use_ = 0;
  Pose last_;  // the last complete cut
  bool has_last_ = false;
  bool lower_complete_ = false;  // of the pose that is cut in halves
  std::vector<int16_t>
      min_phi_;  // per brick: lower bound of its samples, +limit once all air; 7 more
  std::vector<int32_t> touched_;
  size_t touched_count_ = 0;
};

}  // namespace enamel::cutting
