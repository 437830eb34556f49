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
  double coulomb_n = 0, threshold_n = 0;  // sums over tissues as along-travel B; 0 with kBand
};

// The same for turning about the bur's tip.
struct RotationalEngagement {
  Sym3 damping_n_m_s;
  bool shank = false;  // the turn brings the shank into solid
};

// B of each tissue for motion across the bur's axis and along it, N s/m; its Coulomb part and its
// threshold, N.
struct TissueDamping {
  std::array<double, kTissueCount> lateral{}, axial{};
  std::array<double, kTissueCount> coulomb_n{}, threshold_n{};
};

// Which surface points count. kBand: core version 2, kept to replay its recordings. kAhead: since.
enum class EngagementRule { kBand, kAhead };

// Reads engagement: M = integral of m m^T dA over the part of the bur's surface that lies within
// half a voxel of solid and that travel brings into solid; B = sum beta_tissue M. The weight of a
// surface point falls linearly from 1 at the surface to 0 half a voxel away, so B has no steps; and
// no two points lie at one height (SampleSurface), so that B grows evenly where a bur enters a wall.
//
// kAhead. m is the direction into the solid: minus the gradient of the distance field, by
// differences over one voxel (which the interpolation's own error, of that period, does not reach).
// Travel d (unit) brings a point with normal n into solid at the rate s = min(n . d, m . d): the
// bur's own normal is the wrong judge at a wall that it runs along, where an arc of it lies in the
// half-voxel band and faces the way back, and the field alone at a wall behind it. The weight rises
// from 0 at s = kGrazing to 1 at s = kAheadOf, so that B has no steps here either. Withdrawal along
// the way in therefore meets nothing, whatever the bur, its depth or the grid; and m m^T, unlike
// n n^T, couples no motion along a wall to a press against it. In steady cutting the front is the
// bur's own print, m = n, and travel, which is the coupling's stretch, stands along B v: what the
// dead zone takes is less than kAheadOf^3 / 3 of the front's integral. A point that is already a
// tenth of a voxel inside solid counts from s = 0 on: grazing travel creeps no deeper than that.
//
// kBand. m is n, and a point counts when n . travel > 0: the band then resists withdrawal.
//
// beta (N s / m^3) is chosen so that a cylinder of radius 0.6 mm and length 4 mm that moves
// sideways with its front half engaged meets the tissue's lateral B: its integral of (n.d)^2 over
// the half cylinder is r L pi/2 = 3.77 mm^2 (kReferenceArea_m2). Where a bur cuts less well with
// its end than with its side, a point's beta is lateral (1 - n_z^2) + axial n_z^2, n_z being its
// normal's share along the bur's axis: still symmetric and positive semi-definite, whatever the
// travel.
//
// The Coulomb part and the threshold are read as B along travel is, sum over tissues of
// value / kReferenceArea_m2 times the integral of (m . d)^2 dA: the tissue's own at the reference.
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
  static constexpr double kGrazing = 0.06, kAheadOf = 0.18;  // of the travel; sines

  EngagementReader(const Bur& bur, double voxel_m, const TissueDamping& damping,
                   EngagementRule rule = EngagementRule::kAhead);

  // Finds the surface points in contact at `pose`. Work: at most kMaxPoints + kMaxShankPoints
  // trilinear reads; kAhead: and as many gradients.
  ENAMEL_REALTIME void Sample(const Volume& volume, const Pose& pose) noexcept;
  // For travel along `travel` (any length), from the last Sample.
  ENAMEL_REALTIME Engagement Read(const dvec3& travel) const noexcept;
  // Rotational damping of the sampled contact about the bur's tip, N m s: sum beta (r x m)(r x
  // m)^T, for a turn about `turn` (any length; kBand: whatever the turn).
  ENAMEL_REALTIME RotationalEngagement ReadRotational(const dvec3& turn) const noexcept;
  bool AnyContact() const noexcept { return active_count_ != 0; }
  // Saves or restores the last Sample. Not real-time.
  void VisitState(StateArchive& archive) { archive(active_, active_count_); }
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
    dvec3 into;      // m, scene frame
    dvec3 arm;       // from the tip, scene frame, m
    double area_m2;  // weighted
    double beta;
    double coulomb, threshold;  // N/m^2
    double grazing;             // rate from which it counts
    bool shank;
  };

  dvec3 IntoSolid(const Volume& volume, const dvec3& sample, const dvec3& normal) const noexcept;
  static double WeightAhead(const Active& a, const dvec3& direction) noexcept;
  Engagement ReadBand(const dvec3& travel) const noexcept;

  std::vector<Point> points_;
  TissueDamping per_area_;
  std::vector<Active> active_;
  size_t active_count_ = 0;
  double voxel_m_;
  EngagementRule rule_;
};

}  // namespace enamel::cutting
