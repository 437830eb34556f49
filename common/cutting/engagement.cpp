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

// I(1/2) of engagement.h: sqrt(pi) Gamma(5/4)/Gamma(7/4).
constexpr double kHalfPower = 1.7480383695280799;

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
      const dvec3 at = p.position_m / voxel_m;
      const double radius = std::sqrt(at.x * at.x + at.y * at.y),
                   over = radius > 0 ? 1 / radius : 0;
      // The bur's axis points to the handpiece, so its surface goes along -z x r.
      points_.push_back({at, p.normal, p.area_m2, p.normal.z * p.normal.z, radius, at.y * over,
                         -at.x * over, shank});
    }
  };
  // At the finest 0.26 mm apart for a cylinder of 0.6 x 4 mm.
  add(SampleSurface(bur, kSpacing_voxels * voxel_m, kMaxPoints), false);
  add(SampleShank(bur, kSpacing_voxels * voxel_m, kMaxShankPoints), true);
  per_area_ = PerAreaOf(damping);
  candidates_.resize(points_.size());
  facing_.resize(points_.size());
  contacts_.resize(points_.size());
  ahead_.resize(points_.size());
  clear_.resize(points_.size(), static_cast<float>(kUnknown));
  for (const Point& p : points_)
    reach_m_ = HigherOf(reach_m_, voxel_m * std::sqrt(Dot(p.position, p.position)));
}

// From the reference engagement to an element: over its integral of (n . d)^(1+m).
EngagementReader::PerArea EngagementReader::PerAreaOf(const TissueDamping& damping) noexcept {
  PerArea out;
  for (size_t t = 0; t < kTissueCount; ++t) {
    out.lateral[t] = damping.lateral[t] / kReferenceArea_m2;
    out.axial[t] = damping.axial[t] / kReferenceArea_m2;
    out.linear_share[t] = damping.exponent[t] == FeedExponent::kOne;
    out.coulomb[t] = damping.coulomb_n[t] / (2 * kReferenceRadiusLength_m2);
    out.friction[t] = damping.friction[t];
    const double feed = damping.feed_m_per_s[t];
    if (damping.exponent[t] == FeedExponent::kHalf) {
      const double root = std::sqrt(feed) / (kHalfPower * kReferenceRadiusLength_m2);
      out.root_lateral[t] = damping.lateral[t] * root;
      out.root_axial[t] = damping.axial[t] * root;
    } else if (damping.exponent[t] == FeedExponent::kNone) {
      out.coulomb[t] += damping.lateral[t] * feed / (2 * kReferenceRadiusLength_m2);
    }
    out.by_load =
        out.by_load || out.coulomb[t] > 0 || out.root_lateral[t] > 0 || out.friction[t] > 0;
  }
  return out;
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
  c.beta = c.linear = c.coulomb = c.root = c.friction = 0;
  if (p.shank) return;
  // Half a voxel ahead: at the point itself there may be what was cut already.
  const auto t = static_cast<size_t>(volume.TissueAtSample(at + normal * kReach));
  const double lateral = per_area_.lateral[t];
  c.beta = lateral + p.axial_share * (per_area_.axial[t] - lateral);
  if (!per_area_.by_load) return;
  c.linear = c.beta * per_area_.linear_share[t];
  const double root = per_area_.root_lateral[t];
  c.root = root + p.axial_share * (per_area_.root_axial[t] - root);
  c.coulomb = per_area_.coulomb[t];
  c.friction = per_area_.friction[t];
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
  ahead_count_ = 0;
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
    out.damping_n_s_per_m += Sym3::Outer(a.press, a.beta * area);
    if (per_area_.by_load) {
      out.by_load = out.by_load || a.coulomb > 0 || a.root > 0 || a.friction > 0;
      const Point& p = points_[candidates_[i].point];
      ahead_[ahead_count_++] = {a.press,    a.coulomb * area, a.root * area, a.linear * area,
                                a.friction, p.radius,         p.way_x,       p.way_y};
    }
    cutting += a.press * area;
    out.area_m2 += area;
  }
  out.mean_normal = Unit(cutting + shank);
  out.shank_normal = Unit(shank);
  return out;
}

Sym3 EngagementReader::Secant(const dvec3& feed_m_per_s, double speed_ratio) const noexcept {
  Sym3 out;
  const double thicker = 1 / speed_ratio, root_thicker = std::sqrt(thicker);
  for (size_t k = 0; k < ahead_count_; ++k) {
    const Ahead& a = ahead_[k];
    const double own = HigherOf(Dot(a.press, feed_m_per_s), kCreep_m_per_s);
    // p/own, with one division.
    const double slow = 1 / std::sqrt(own);
    const double b = a.coulomb_n * slow * slow + a.root * root_thicker * slow + a.linear * thicker;
    out += Sym3::Outer(a.press, b);
  }
  return out;
}

FeedForce EngagementReader::Along(const dvec3& direction, double speed_ratio) const noexcept {
  double coulomb = 0, root = 0, linear = 0;
  for (size_t k = 0; k < ahead_count_; ++k) {
    const Ahead& a = ahead_[k];
    const double along = HigherOf(Dot(a.press, direction), 0);
    coulomb += along * a.coulomb_n;
    root += along * std::sqrt(along) * a.root;
    linear += along * along * a.linear;
  }
  const double thicker = 1 / speed_ratio;
  return {coulomb, root * std::sqrt(thicker), linear * thicker};
}

BurDrag EngagementReader::Drag(const dvec3& feed_m_per_s, double speed_ratio) const noexcept {
  double x = 0, y = 0, torque = 0;
  const double thicker = 1 / speed_ratio, root_thicker = std::sqrt(thicker);
  for (size_t k = 0; k < ahead_count_; ++k) {
    const Ahead& a = ahead_[k];
    const double own = Dot(a.press, feed_m_per_s);
    if (!(own > 0)) continue;
    const double drag_n = a.friction * (a.coulomb_n + a.root * root_thicker * std::sqrt(own) +
                                        a.linear * thicker * own);
    x += drag_n * a.way_x;
    y += drag_n * a.way_y;
    torque += drag_n * a.radius;
  }
  return {InScene(dvec3(x, y, 0)), torque * voxel_m_};
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
