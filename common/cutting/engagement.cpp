#include "common/cutting/engagement.h"

#include <algorithm>
#include <cmath>

#include "common/cutting/sweep.h"
#include "common/math/order.h"

namespace enamel::cutting {
namespace {

dvec3 Unit(const dvec3& v) noexcept {
  double length = std::sqrt(Dot(v, v));
  return length > 0 ? v * (1 / length) : dvec3(0);
}

// No source is recorded for these numbers. They must satisfy two tests: a bur that is drawn back
// meets nothing (EngagementTest.BurDrawnUpItsAxisMeetsNothingAtAnyDepth,
// qualify/withdrawal_test.cpp), and a bur in its seat meets the integral over its front within some
// per cent (EngagementTest). Change one, and run these; the golden recordings move as well.
constexpr double kReach = 0.5;  // voxels
// Of a single-precision number that stands for a distance, over some hundred subtractions, voxels.
constexpr double kRounding = 1e-4;
// Of a distance that is not known: below any that there is; and one so long ago that a look at the nearest
// sample pays before all samples are read.
constexpr double kUnknown = -100, kLongAgo = -3;
// A trilinear distance between samples that differ by no more than their way changes by at most this much of a
// way: by 1 along each axis.
constexpr double kSteepest = 1.7321;
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
  if (distance >= 0) return EngagementReader::kGrazing + distance * (1 / kLookAhead);
  double outside = 1 + distance * (1 / kInside);
  return outside > 0 ? EngagementReader::kGrazing * outside : 0;
}

// The direction a point presses in.
dvec3 Press(const dvec3& normal, const dvec3& into) noexcept {
  double own = (Dot(normal, into) - kFieldBelow) * (1 / (kOwnFrom - kFieldBelow));
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
  // At the finest 0.26 mm apart for a cylinder of 0.6 x 4 mm.
  add(SampleSurface(bur, kSpacing_voxels * voxel_m, kMaxPoints), false);
  add(SampleShank(bur, kSpacing_voxels * voxel_m, kMaxShankPoints), true);
  for (size_t t = 0; t < kTissueCount; ++t) {
    per_area_.lateral[t] = damping.lateral[t] / kReferenceArea_m2;
    per_area_.axial[t] = damping.axial[t] / kReferenceArea_m2;
    per_area_.coulomb_n[t] = damping.coulomb_n[t] / kReferenceArea_m2;
    per_area_.threshold_n[t] = damping.threshold_n[t] / kReferenceArea_m2;
  }
  candidates_.resize(points_.size());
  facing_.resize(points_.size());
  contacts_.resize(points_.size());
  clear_.resize(points_.size(), static_cast<float>(kUnknown));
  for (const Point& p : points_)
    reach_m_ = HigherOf(reach_m_, voxel_m * std::sqrt(Dot(p.position, p.position)));
}

void EngagementReader::Forget() noexcept {
  std::fill(clear_.begin(), clear_.end(), static_cast<float>(kUnknown));
}

dvec3 EngagementReader::InBur(const dvec3& scene) const noexcept {
  return {Dot(axes_[0], scene), Dot(axes_[1], scene), Dot(axes_[2], scene)};
}

void EngagementReader::Sample(const Volume& volume, const Pose& pose) noexcept {
  axes_ = pose.orientation.Matrix();
  tip_ = (pose.tip_m - volume.spec().origin_m()) / voxel_m_;
  // Most points are far from solid, and stay so for a while: cutting only makes distances larger.
  const auto closer = static_cast<float>(kSteepest * Motion(pose, last_, reach_m_) / voxel_m_);
  last_ = pose;
  for (float& clear : clear_) clear -= closer;
  // Each is written, and kept or not: a branch would be guessed wrongly at every other point.
  size_t near = 0;
  for (size_t i = 0; i < points_.size(); ++i) {
    candidates_[near] = {static_cast<uint32_t>(i), false};
    near += clear_[i] < kReach;
  }
  count_ = 0;
  for (size_t i = 0; i < near; ++i) {
    const Candidate candidate = candidates_[i];
    float& clear = clear_[candidate.point];
    if (clear < kLongAgo) {
      const dvec3 at = tip_ + InScene(points_[candidate.point].position);
      clear = static_cast<float>(volume.ClearanceAtSample(at) - kRounding);
    }
    candidates_[count_] = candidate;
    count_ += clear < kReach;
  }
}

void EngagementReader::Look(const Volume& volume, size_t candidate) noexcept {
  Candidate& who = candidates_[candidate];
  Contact& c = contacts_[candidate];
  who.seen = true;
  const Point& p = points_[who.point];
  const dvec3 at = tip_ + InScene(p.position);
  dvec3 slope;
  const double distance = volume.DistanceAndSlope(at, kReach, slope);
  clear_[who.point] = static_cast<float>(distance - kRounding);
  c.area_m2 = 0;
  if (distance >= kReach) return;
  const dvec3 normal = InScene(p.normal);
  c.grazing = Grazing(distance);
  c.area_m2 = p.area_m2 * (distance <= 0 ? 1 : 1 - distance * (1 / kReach));
  const double steepness = std::sqrt(Dot(slope, slope));
  // Else the bur's own normal is the best that is known.
  c.into = steepness >= kSlope ? slope * (-1 / steepness) : normal;
  if (steepness < kPlainWall) c.area_m2 *= SolidShare(volume, at, distance, c.into);
  if (!(c.area_m2 > 0)) return;
  c.press = Press(normal, c.into);
  c.beta = c.coulomb = c.threshold = 0;
  if (p.shank) return;
  // Half a voxel ahead: at the point itself there may be what was cut already.
  const auto t = static_cast<size_t>(volume.TissueAtSample(at + normal * kReach));
  const double lateral = per_area_.lateral[t];
  c.beta = lateral + p.axial_share * (per_area_.axial[t] - lateral);
  c.coulomb = per_area_.coulomb_n[t];
  c.threshold = per_area_.threshold_n[t];
}

// Its area, by how far that direction brings it into solid, m^2.
double EngagementReader::AreaAhead(const Volume& volume, const dvec3& direction, double own,
                                   size_t candidate) noexcept {
  const Contact& c = See(volume, candidate);
  if (!(c.area_m2 > 0) || !(own > c.grazing)) return 0;
  const double field = Dot(c.into, direction), rate = own < field ? own : field;
  if (!(rate > c.grazing)) return 0;
  const double weight = (rate - c.grazing) * (1 / kRamp);
  return c.area_m2 * (weight < 1 ? weight : 1);
}

bool EngagementReader::Touches(const Volume& volume) noexcept {
  for (size_t i = 0; i < count_; ++i)
    if (See(volume, i).area_m2 > 0) return true;
  return false;
}

Engagement EngagementReader::Read(const Volume& volume, const dvec3& travel) noexcept {
  Engagement out;
  const dvec3 direction = Unit(travel), in_bur = InBur(direction);
  dvec3 cutting(0), shank(0);
  // The cheapest first: half of a bur's points face away from its travel. As in Sample.
  size_t facing = 0;
  for (size_t i = 0; i < count_; ++i) {
    const double own = Dot(points_[candidates_[i].point].normal, in_bur);
    facing_[facing] = {static_cast<uint32_t>(i), own};
    facing += own > 0;
  }
  for (size_t k = 0; k < facing; ++k) {
    const size_t i = facing_[k].candidate;
    const double area = AreaAhead(volume, direction, facing_[k].own, i);
    if (!(area > 0)) continue;
    const Contact& a = contacts_[i];
    if (points_[candidates_[i].point].shank) {
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

RotationalEngagement EngagementReader::ReadRotational(const Volume& volume,
                                                      const dvec3& turn) noexcept {
  RotationalEngagement out;
  for (size_t i = 0; i < count_; ++i) {
    const dvec3 arm_m = InScene(points_[candidates_[i].point].position) * voxel_m_;
    // A point moves as turn x arm; one on the axis of the turn does not move, and weighs 0.
    const dvec3 direction = Unit(glm::cross(turn, arm_m));
    const double own = Dot(points_[candidates_[i].point].normal, InBur(direction));
    if (!(own > 0)) continue;
    const double area = AreaAhead(volume, direction, own, i);
    if (!(area > 0)) continue;
    const Contact& a = contacts_[i];
    const bool shank = points_[candidates_[i].point].shank;
    out.shank = out.shank || shank;
    out.area_m2 += area;
    if (shank) out.shank_area_m2 += area;
    out.damping_n_m_s += Sym3::Outer(glm::cross(arm_m, a.press), a.beta * area);
  }
  return out;
}

}  // namespace enamel::cutting
