#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/base/check.h"
#include "common/base/state_archive.h"
#include "common/cutting/bur.h"
#include "common/cutting/volume.h"
#include "common/math/sym3.h"

namespace enamel::cutting {

// What the bur's surface touches, for travel along one direction.
struct Engagement {
  Sym3 damping_n_s_per_m;  // sum over tissues of beta_t * integral of n n^T dA; cutting part only
  dvec3 mean_normal{0};    // area-weighted outward normal of the engaged surface, unit or 0
  dvec3 shank_normal{0};   // the same of the engaged part of the shank
  double area_m2 = 0;      // of the cutting part
};

// B of each tissue for motion across the bur's axis and along it, N s/m.
struct TissueDamping {
  std::array<double, kTissueCount> lateral{}, axial{};
};

// Reads engagement: M = integral of n n^T dA over the part of the bur's surface that lies within
// half a voxel of solid and whose outward normal n has n . travel > 0; B = sum beta_tissue M.
// Motion out of the material therefore meets no resistance. The weight of a surface point falls
// linearly from 1 at the surface to 0 half a voxel away, so B has no steps; and no two points lie
// at one height (SampleSurface), so that B grows evenly where a bur enters a wall.
//
// beta (N s / m^3) is chosen so that a cylinder of radius 0.6 mm and length 4 mm that moves
// sideways with its front half engaged meets the tissue's lateral B: its integral of (n.d)^2 over
// the half cylinder is r L pi/2 = 3.77 mm^2 (kReferenceArea_m2). Where a bur cuts less well with
// its end than with its side, a point's beta is lateral (1 - n_z^2) + axial n_z^2, n_z being its
// normal's share along the bur's axis: still symmetric and positive semi-definite, whatever the
// travel.
//
// The shank does not cut: its points in contact only have a normal, the wall's.
//
// Sampling (where the surface meets solid) and summing (for one direction) are apart: the samples
// only change when the bur has moved or cut.
// Thread safety: none. Real-time: Sample and Read are safe; the constructor allocates.
class EngagementReader {
 public:
  static constexpr double kReferenceArea_m2 = 0.6e-3 * 4e-3 * 1.57079632679489661923;
  static constexpr size_t kMaxPoints = 256, kMaxShankPoints = 160;

  EngagementReader(const Bur& bur, double voxel_m, const TissueDamping& damping);

  // Finds the surface points in contact at `pose`. Work: at most kMaxPoints + kMaxShankPoints
  // trilinear reads.
  ENAMEL_REALTIME void Sample(const Volume& volume, const Pose& pose) noexcept;
  // For travel along `travel` (any length), from the last Sample.
  ENAMEL_REALTIME Engagement Read(const dvec3& travel) const noexcept;
  // Rotational damping of the sampled contact about the bur's tip, N m s: sum beta (r x n)(r x
  // n)^T.
  ENAMEL_REALTIME Sym3 ReadRotational() const noexcept;
  bool AnyContact() const noexcept { return active_count_ != 0; }
  bool ShankContact() const noexcept { return shank_contact_; }
  // Saves or restores the last Sample. Not real-time.
  void VisitState(StateArchive& archive) { archive(active_, active_count_, shank_contact_); }
  size_t point_count() const noexcept { return points_.size(); }

 private:
  struct Point {
    dvec3 position;  // bur frame, voxels
    dvec3 normal;
    double area_m2;
    double axial_share;  // n_z^2
    bool shank;
  };
  struct Active {
    dvec3 normal;    // scene frame
    dvec3 arm;       // from the tip, scene frame, m
    double area_m2;  // weighted
    double beta;
    bool shank;
  };
  std::vector<Point> points_;
  TissueDamping beta_;
  std::vector<Active> active_;
  size_t active_count_ = 0;
  bool shank_contact_ = false;
  double voxel_m_;
};

}  // namespace enamel::cutting
