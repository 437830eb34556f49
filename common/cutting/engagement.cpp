#include "common/cutting/engagement.h"

#include <cmath>

namespace enamel::cutting {
namespace {

dvec3 Unit(const dvec3& v) noexcept {
  double length = std::sqrt(Dot(v, v));
  return length > 0 ? v / length : dvec3(0);
}

// No source is recorded for these numbers. They must satisfy two tests: a bur that is drawn back
// meets nothing (EngagementTest.BurDrawnUpItsAxisMeetsNothingAtAnyDepth,
// qualify/withdrawal_test.cpp), and a bur in its seat meets the integral over its front within some
// per cent (EngagementTest). Change one, and run these; the golden recordings move as well.
constexpr double kReach = 0.5;  // voxels
// Voxels inside solid at which a point counts for any travel into it.
constexpr double kInside = 0.03;
// Cosines between a point's own normal and the way into the solid.
constexpr double kOwnFrom = 0.75, kFieldBelow = 0.5;
// Voxels of travel that have to bring a point outside solid into it.
constexpr double kLookAhead = 0.5;
// Voxels behind the surface where there must be solid.
constexpr double kThin = 0.25;
// A distance field's slope is 1. Below this share of it there is no direction: where two walls are
// equally near, or deeper in solid than the field is kept.
constexpr double kSlope = 0.5;
// From here on it is a wall. Half a voxel from a film's middle the field falls and rises again, so
// that the change over a voxel stays below this where the film could count.
constexpr double kPlainWall = 0.97;

// The rate from which a point at that distance counts.
double Grazing(double distance) noexcept {
  if (distance >= 0) return EngagementReader::kGrazing + distance / kLookAhead;
  double outside = 1 + distance / kInside;
  return outside > 0 ? EngagementReader::kGrazing * outside : 0;
}

// The direction a point presses in.
dvec3 Press(const dvec3& normal, const dvec3& into) noexcept {
  double own = (Dot(normal, into) - kFieldBelow) / (kOwnFrom - kFieldBelow);
  if (own >= 1) return normal;
  if (!(own > 0)) return into;
  return Unit(into + (normal - into) * own);
}

// Whether there is solid where the field says it begins: 1, 0, or a share where it is thinner than
// kThin. The largest of two distances (cutter.h) is no distance where a face of the bur lay near
// the tooth's surface: a film of small values is left there, without any solid in it.
double SolidShare(const Volume& volume, const dvec3& at, double distance,
                  const dvec3& into) noexcept {
  if (distance <= -kThin) return 1;
  double beyond = volume.DistanceAtSample(at + into * ((distance > 0 ? distance : 0) + kThin));
  double share = -2 / kThin * beyond;
  return share < 0 ? 0 : share > 1 ? 1 : share;
}

}  // namespace

EngagementReader::EngagementReader(const Bur& bur, double voxel_m, const TissueDamping& damping)
    : voxel_m_(voxel_m) {
  auto add = [&](const std::vector<SurfacePoint>& points, bool shank) {
    for (const SurfacePoint& p : points) {
      points_.push_back(
          {p.position_m / voxel_m, p.normal, p.area_m2, p.normal.z * p.normal.z, shank});
    }
  };
  // Three voxels apart, or as near as kMaxPoints allows: 0.26 mm for a cylinder of 0.6 x 4 mm.
  add(SampleSurface(bur, 3 * voxel_m, kMaxPoints), false);
  add(SampleShank(bur, 3 * voxel_m, kMaxShankPoints), true);
  for (size_t t = 0; t < kTissueCount; ++t) {
    per_area_.lateral[t] = damping.lateral[t] / kReferenceArea_m2;
    per_area_.axial[t] = damping.axial[t] / kReferenceArea_m2;
    per_area_.coulomb_n[t] = damping.coulomb_n[t] / kReferenceArea_m2;
    per_area_.threshold_n[t] = damping.threshold_n[t] / kReferenceArea_m2;
  }
  active_.resize(points_.size());
}

void EngagementReader::Sample(const Volume& volume, const Pose& pose) noexcept {
  active_count_ = 0;
  const dmat3 m = pose.orientation.Matrix();
  const dvec3 tip = (pose.tip_m - volume.spec().origin_m()) / voxel_m_;
  for (const Point& p : points_) {
    dvec3 arm = m[0] * p.position.x + m[1] * p.position.y + m[2] * p.position.z, at = tip + arm;
    // Most points are far from solid: one sample tells, instead of eight.
    if (!volume.MayBeNearer(at, kReach)) continue;
    double distance = volume.DistanceAtSample(at);
    if (distance >= kReach) continue;
    Active a;
    a.normal = m[0] * p.normal.x + m[1] * p.normal.y + m[2] * p.normal.z;
    a.into = a.normal;
    a.area_m2 = p.area_m2 * (distance <= 0 ? 1 : 1 - distance / kReach);
    dvec3 out = volume.SlopeAtSample(at);
    double slope = std::sqrt(Dot(out, out));
    // Else the bur's own normal is the best that is known.
    if (slope >= kSlope) a.into = out * (-1 / slope);
    if (slope < kPlainWall) a.area_m2 *= SolidShare(volume, at, distance, a.into);
    if (!(a.area_m2 > 0)) continue;
    a.press = Press(a.normal, a.into);
    a.arm = arm * voxel_m_;
    a.beta = a.coulomb = a.threshold = 0;
    a.grazing = Grazing(distance);
    a.shank = p.shank;
    if (!p.shank) {
      // Half a voxel ahead: at the point itself there may be what was cut already.
      auto t = static_cast<size_t>(volume.TissueAtSample(at + a.normal * kReach));
      double lateral = per_area_.lateral[t];
      a.beta = lateral + p.axial_share * (per_area_.axial[t] - lateral);
      a.coulomb = per_area_.coulomb_n[t];
      a.threshold = per_area_.threshold_n[t];
    }
    active_[active_count_++] = a;
  }
}

double EngagementReader::WeightAhead(const Active& a, const dvec3& direction) noexcept {
  // The cheaper of the two first: most points of a bur face away from its travel.
  double own = Dot(a.normal, direction);
  if (!(own > a.grazing)) return 0;
  double field = Dot(a.into, direction), rate = own < field ? own : field;
  if (!(rate > a.grazing)) return 0;
  double weight = (rate - a.grazing) / kRamp;
  return weight < 1 ? weight : 1;
}

Engagement EngagementReader::Read(const dvec3& travel) const noexcept {
  Engagement out;
  const dvec3 direction = Unit(travel);
  dvec3 cutting(0), shank(0);
  for (size_t i = 0; i < active_count_; ++i) {
    const Active& a = active_[i];
    double area = a.area_m2 * WeightAhead(a, direction);
    if (!(area > 0)) continue;
    if (a.shank) {
      shank += a.press * area;
      continue;
    }
    double along = Dot(a.press, direction), square = along * along * area;
    out.damping_n_s_per_m += Sym3::Outer(a.press, a.beta * area);
    out.coulomb_n += a.coulomb * square;
    out.threshold_n += a.threshold * square;
    cutting += a.press * area;
    out.area_m2 += area;
  }
  out.mean_normal = Unit(cutting + shank);
  out.shank_normal = Unit(shank);
  return out;
}

RotationalEngagement EngagementReader::ReadRotational(const dvec3& turn) const noexcept {
  RotationalEngagement out;
  for (size_t i = 0; i < active_count_; ++i) {
    const Active& a = active_[i];
    // A point moves as turn x arm; one on the axis of the turn does not move, and weighs 0.
    double area = a.area_m2 * WeightAhead(a, Unit(glm::cross(turn, a.arm)));
    if (!(area > 0)) continue;
    out.shank = out.shank || a.shank;
    out.area_m2 += area;
    if (a.shank) out.shank_area_m2 += area;
    out.damping_n_m_s += Sym3::Outer(glm::cross(a.arm, a.press), a.beta * area);
  }
  return out;
}

}  // namespace enamel::cutting
