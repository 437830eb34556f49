#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/check.h"
#include "common/base/state_archive.h"
#include "common/cutting/bur.h"
#include "common/cutting/tissue.h"
#include "common/cutting/volume.h"
#include "common/math/feed_force.h"
#include "common/math/sym3.h"

namespace enamel::cutting {

// The tissue that the bur's surface touches, for travel along one direction.
struct Engagement {
  // Sum over tissues of beta_t * integral of n n^T dA; cutting part only. Tissue that is cut by load counts with its B at v0.
  Sym3 damping_n_s_per_m;
  dvec3 mean_normal{0};   // area-weighted outward normal of the engaged surface, unit or 0
  dvec3 shank_normal{0};  // the same of the engaged part of the shank
  double area_m2 = 0;     // of the cutting part
  bool by_load = false;   // a tissue among them is cut by load: Secant, Along and Drag say how
};

// Friction on the surface of a turning bur: the force with which the holder must resist it, and the torque on the spindle.
struct BurDrag {
  dvec3 force_n{0};
  double torque_n_m = 0;
};

// Engagement in a turn about the bur's tip. Tissue that is cut by load resists a turn with its B at v0, a
// simplification: the feeds of a turn are small and differ along the bur.
struct RotationalEngagement {
  Sym3 damping_n_m_s;
  bool shank = false;  // the turn brings the shank into solid
  // Weighted area of the surface that the turn brings into solid, m^2, and the shank's part of it.
  double area_m2 = 0, shank_area_m2 = 0;
};

// The force that cutting a tissue takes at the reference engagement: coulomb + B v0 (v/v0)^m. With m = 1, the default,
// and without a Coulomb part it is B v, whatever v0 is: eq. 1 of Liu et al. 2008.
struct TissueDamping {
  std::array<double, kTissueCount> lateral{},
      axial{};                                   // B across the bur's axis and along it, N s/m
  std::array<double, kTissueCount> coulomb_n{};  // below it the bur does not cut
  FeedExponents exponent = AllLinear();
  std::array<double, kTissueCount> feed_m_per_s{};  // v0; not used with m = 1
  std::array<double, kTissueCount> friction{};      // mu of the bur's turning surface
};

// Reads engagement: M = integral of u u^T dA over the part of the bur's surface that is within half
// a voxel of solid and that travel brings into solid; B = sum beta_tissue M. The weight of a
// surface point falls linearly from 1 at the surface to 0 half a voxel away, so B has no steps. No
// two points are at one height (SampleSurface), so that B grows evenly where a bur enters a wall.
//
// Resistance comes only from tissue ahead. Let n be a point's outward normal, phi its distance to
// the solid in voxels, and m the way into the solid there. m is minus the gradient of the distance
// field, by differences over one voxel: the interpolation's own error has that period and drops
// out.
//  * Travel d (unit) brings the point into solid at the rate s = min(n . d, m . d). The bur's own
//    normal alone is wrong at a wall that the bur runs along: an arc of it is in the half-voxel
//    band, and half of that faces the way back. The field alone is wrong at a wall behind the bur.
//  * The point counts from s = kGrazing + 2 max(phi, 0) on (half a voxel of travel brings it in)
//    and fully at kRamp more. Three hundredths of a voxel inside solid it counts from s = 0 on:
//    grazing travel creeps no deeper than that.
//  * There must be solid a quarter of a voxel behind the surface that the field shows:
//    max(phi_tooth, -phi_bur) leaves a film of small distances where a face of the bur was near the
//    tooth's surface, as under a bur sunk to its top.
//  * u = n where n and m agree (cosine above 0.75), m where they do not (below 0.5), such as at the
//    rim of a face that runs along a wall: no press against a wall then resists the way along it.
// In steady cutting the front is the bur's own print, m = n, and travel, which is the coupling's
// stretch, is along B v, so that the dead zone costs little.
//
// beta (N s / m^3) is chosen so that a cylinder of radius 0.6 mm and length 4 mm that moves
// sideways with its front half engaged meets the tissue's lateral B: its integral of (n.d)^2 over
// the half cylinder is r L pi/2 = 3.77 mm^2 (kReferenceArea_m2). Where a bur cuts less well with
// its end than with its side, a point's beta is lateral (1 - n_z^2) + axial n_z^2, n_z being its
// normal's share along the bur's axis. This is still symmetric and positive semi-definite, whatever
// the travel.
//
// Tissue cut by load (a Coulomb part, or m below 1) presses on each element dA of the front with
//   p = p0 + k (u . v)^m,    R = integral (p u + mu p t) dA,
// where t is the direction in which the bur's own surface moves there. p0 and k are chosen so that the reference cylinder meets the
// tissue's own coulomb + B v0 (v/v0)^m: its integral of (n . d)^(1+m) over the half cylinder is
// r L I(m), I(0) = 2, I(1/2) = sqrt(pi) Gamma(5/4)/Gamma(7/4), I(1) = pi/2. A feed at another speed w of
// the spindle cuts as v w0/w at the free speed w0: the chip per turn counts. The end of the bur cuts
// worse by the axial B alone; its lower surface speed is in that.
//
// The shank does not cut: its points in contact only have a normal, the wall's.
//
// Sampling (which points may be near solid) and summing (for one direction) are apart: the samples only change
// when the bur has moved. A point is read when travel towards it is asked for, once.
// Thread safety: none. Real-time: Sample and Read are safe; the constructor allocates.
class EngagementReader {
 public:
  static constexpr double kReferenceRadiusLength_m2 = 0.6e-3 * 4e-3;
  static constexpr double kReferenceArea_m2 = kReferenceRadiusLength_m2 * 1.57079632679489661923;
  static constexpr size_t kMaxPoints = 256, kMaxShankPoints = 160;
  static constexpr double kSpacing_voxels = 3;  // of the points, or as near as these numbers allow
  static constexpr double kGrazing = 0.06, kRamp = 0.12;  // rates

  EngagementReader(const Bur& bur, double voxel_m, const TissueDamping& damping);

  // Finds the surface points that may be near solid at `pose`. A point that was far from solid is left out until
  // the bur could have brought it there.
  // Requires, here and below: the same volume as in the last call, with nothing added to it since; else Forget
  // first.
  // Work of a call, here and below: at most kMaxPoints + kMaxShankPoints reads of 27 samples; none twice.
  ENAMEL_REALTIME void Sample(const Volume& volume, const Pose& pose) noexcept;
  // For travel along `travel` (any length), from the last Sample.
  ENAMEL_REALTIME Engagement Read(const Volume& volume, const dvec3& travel) noexcept;
  // These read the tissue that the last Read found ahead, where it is cut by load. `speed_ratio`: w/w0 of the spindle.
  // Secant: the B with which B v is the force at the feed v, each element's own feed taken as at least kCreep.
  static constexpr double kCreep_m_per_s = 1e-6;
  ENAMEL_REALTIME Sym3 Secant(const dvec3& feed_m_per_s, double speed_ratio) const noexcept;
  // Along a direction of length 1.
  ENAMEL_REALTIME FeedForce Along(const dvec3& direction, double speed_ratio) const noexcept;
  // The bur turns clockwise, seen from the handpiece.
  ENAMEL_REALTIME BurDrag Drag(const dvec3& feed_m_per_s, double speed_ratio) const noexcept;
  // Rotational damping of the sampled contact about the bur's tip, N m s: sum beta (r x u)(r x
  // u)^T, for a turn about `turn` (any length).
  ENAMEL_REALTIME RotationalEngagement ReadRotational(const Volume& volume,
                                                      const dvec3& turn) noexcept;
  // False only where nothing is in contact, whatever the travel.
  bool MayTouch() const noexcept { return count_ != 0; }
  ENAMEL_REALTIME bool Touches(const Volume& volume) noexcept;
  // Reads every point next time.
  void Forget() noexcept;
  // Saves or restores the last Sample. Not real-time.
  void VisitState(StateArchive& archive) {
    archive(candidates_, contacts_, count_, clear_, last_, tip_, axes_);
    ahead_count_ = 0;  // of a Read, and each tick reads anew
  }
  size_t point_count() const noexcept { return points_.size(); }

 private:
  struct Point {
    dvec3 position;  // bur frame, voxels
    dvec3 normal;
    double area_m2;
    double axial_share;  // n_z^2
    // From the axis; the way of the turning surface, of length 1 or none.
    double radius, way_x, way_y;
    bool shank;
  };
  // A point that may be near solid.
  struct Candidate {
    uint32_t point;
    bool seen;  // its Contact was read
  };
  // A candidate that faces travel, for the time of a Read.
  struct Facing {
    uint32_t candidate;
    double own;
  };
  // What is there.
  struct Contact {
    dvec3 into;      // m, scene frame
    dvec3 press;     // u, scene frame
    double grazing;  // rate from which it counts
    double area_m2;  // weighted; 0: not in contact
    // N s/m^3: B at the tissue's own feed; the part of it that is linear. N/m^2. N s^1/2 m^-5/2.
    double beta, linear, coulomb, root;
    double friction;
  };
  // A point of the last Read, where a tissue is cut by load: all that its pressure needs in one place, since a
  // tick passes over these points three times. Forces, so times its area.
  struct Ahead {
    dvec3 press;
    double coulomb_n, root, linear;
    double friction, radius;  // of the turning surface; voxels
    double way_x, way_y;      // its way, bur frame, of length 1
  };
  // Of a vector: from the bur's frame into the scene's, and back.
  dvec3 InScene(const dvec3& bur) const noexcept {
    return axes_[0] * bur.x + axes_[1] * bur.y + axes_[2] * bur.z;
  }
  dvec3 InBur(const dvec3& scene) const noexcept;
  // What is at a candidate, read once.
  const Contact& See(const Volume& volume, size_t candidate) noexcept {
    if (!candidates_[candidate].seen) Look(volume, candidate);
    return contacts_[candidate];
  }
  void Look(const Volume& volume, size_t candidate) noexcept;
  // `own`: the direction's share along the point's own normal. Requires: own > 0.
  double AreaAhead(const Volume& volume, const dvec3& direction, double own,
                   size_t candidate) noexcept;

  std::vector<Point> points_;
  // Per area of a tissue: N s/m^3, N/m^2, N s^1/2 m^-5/2.
  struct PerArea {
    std::array<double, kTissueCount> lateral{}, axial{}, coulomb{}, root_lateral{}, root_axial{};
    std::array<double, kTissueCount> linear_share{}, friction{};
    bool by_load = false;  // a tissue is
  };
  static PerArea PerAreaOf(const TissueDamping& damping) noexcept;
  PerArea per_area_;
  // The first `count_` are of the last Sample.
  std::vector<Candidate> candidates_;
  std::vector<Contact> contacts_;
  std::vector<Facing> facing_;
  std::vector<Ahead> ahead_;
  size_t ahead_count_ = 0;
  size_t count_ = 0;
  // Of each point: a distance that it surely had at the last Sample, voxels; far below 0: nothing is known.
  std::vector<float> clear_;
  Pose last_;      // of the last Sample
  dvec3 tip_{0};   // there, sample coordinates
  dmat3 axes_{1};  // there: the bur's, in the scene
  double reach_m_ = 0, voxel_m_;
};

}  // namespace enamel::cutting
