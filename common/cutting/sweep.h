#pragma once

#include <array>
#include <span>

#include "common/base/check.h"
#include "common/base/state_archive.h"
#include "common/cutting/bur.h"

namespace enamel::cutting {

// Largest displacement of any point of a bur within `reach_m` of its tip between two poses, bounded
// from above: |q - q'| = 2 sin(angle / 4), so the angle is below 2.3 |q - q'| up to a right angle.
// Real-time: safe.
double Motion(const Pose& a, const Pose& b, double reach_m) noexcept;

// Which poses of a path have to be cut, so that the hole is that of all of them. A pose between two
// that are cut adds at most the ridge between them (cutter.h), (span/2)^2 / 8r, when it is on the
// straight way from one to the other. Poses are therefore skipped as long as every one since the
// last cut is within the tolerance of the straight way to the newest, which is at most a span away.
// Where the path turns, its corner is cut before the bur leaves it. Skipped poses are cut when the
// bur has stayed kPatience moves, or on Flush. So the hole lags behind a moving bur by up to a
// span, and never lacks more than the tolerance.
//
// Tolerance: 1/32 voxel. Span: SpanOf; for r = 0.25 mm its ridge is 0.3 um at h <= 0.05 mm, below 2
// % of a voxel. At h = 0.05 mm or less, 5 mm/s and 1 kHz every fifth tick cuts, at 0.5 mm/s one of
// kPatience.
//
// Thread safety: none. Real-time: safe.
class Sweep {
 public:
  static constexpr size_t kMaxWaiting = 16;
  static constexpr int kPatience = 32;
  static constexpr size_t kMaxDue = kMaxWaiting + 1;

  Sweep(double voxel_m, double reach_m)
      : tolerance_(voxel_m / 32), span_(SpanOf(voxel_m)), reach_(reach_m) {}
  // Half a voxel, or a fortieth of a millimetre where that is more, up to a voxel.
  static double SpanOf(double voxel_m) noexcept {
    return voxel_m > 50e-6 ? 0.5 * voxel_m : voxel_m > 25e-6 ? 25e-6 : voxel_m;
  }

  // The bur is at `to`, at most half a voxel from where it was. The poses to be cut now, in order,
  // at most kMaxDue; one as a rule. Valid until the next call.
  ENAMEL_REALTIME std::span<const Pose> Move(const Pose& to) noexcept;
  // The skipped poses that are not within the tolerance of the last cut.
  ENAMEL_REALTIME std::span<const Pose> Flush() noexcept;
  // Starts again: the next pose is cut. Drops the waiting poses: Flush first.
  void Clear() noexcept;
  void VisitState(StateArchive& archive) { archive(cut_, has_cut_, waiting_, count_, age_); }

 private:
  double Deviation(const Pose& pose, const Pose& to) const noexcept;
  void CutAt(size_t waiting) noexcept;
  void Wait(const Pose& to) noexcept;

  double tolerance_, span_, reach_;
  Pose cut_;
  bool has_cut_ = false;
  std::array<Pose, kMaxWaiting>
      waiting_;  // passed over since the cut, oldest first; the last is newest
  size_t count_ = 0;
  int age_ = 0;  // moves since the cut
  std::array<Pose, kMaxDue> due_;
  size_t due_count_ = 0;
};

}  // namespace enamel::cutting
