#include "common/cutting/engagement.h"

#include <cmath>

namespace enamel::cutting {
namespace {

dvec3 Unit(const dvec3& v) noexcept {
  double length = std::sqrt(Dot(v, v));
  return length > 0 ? v / length : dvec3(0);
}

constexpr double kReach = 0.5;  // voxels
// Voxels inside solid at which a point counts for any travel into it.
constexpr double kInside = 0.1;
// A distance field's slope is 1. Below this share of it there is no direction: where two walls are
// equally near, or deeper in solid than the field is kept.
constexpr double kSlope = 0.5;

}  // namespace

EngagementReader::EngagementReader(const Bur& bur, double voxel_m, const TissueDamping& damping,
                                   EngagementRule rule)
    : voxel_m_(voxel_m), rule_(rule) {
  auto add = [&](const std::vector<SurfacePoint>& points, bool shank) {
    for (const SurfacePoint& p : points) {
      points_.push_back(
          {p.position_m / voxel_m, p.normal, p.area_m2, p.normal.z * p.normal.z, shank});
    }
  };
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
    if (!volume.MayBeNearer(at, kReach)) continue;
    double distance = volume.DistanceAtSample(at);
    if (distance >= kReach) continue;
    Active a;
    a.normal = m[0] * p.normal.x + m[1] * p.normal.y + m[2] * p.normal.z;
    a.into = rule_ == EngagementRule::kAhead ? IntoSolid(volume, at, a.normal) : a.normal;
    a.arm = arm * voxel_m_;
    a.area_m2 = p.area_m2 * (distance <= 0 ? 1 : 1 - distance / kReach);
    a.beta = a.coulomb = a.threshold = 0;
    double outside = 1 + distance / kInside;
    a.grazing = outside >= 1 ? kGrazing : outside <= 0 ? 0 : kGrazing * outside;
    a.shank = p.shank;
    if (!p.shank) {
      auto t = static_cast<size_t>(volume.TissueAtSample(at + a.normal * kReach));
      double lateral = per_area_.lateral[t];
      a.beta = lateral + p.axial_share * (per_area_.axial[t] - lateral);
      a.coulomb = per_area_.coulomb_n[t];
      a.threshold = per_area_.threshold_n[t];
    }
    active_[active_count_++] = a;
  }
}

// Differences over a voxel along each axis: trilinear interpolation of a curved wall errs by bumps
// of one voxel's period, which are the same at both ends.
dvec3 EngagementReader::IntoSolid(const Volume& volume, const dvec3& at,
                                  const dvec3& normal) const noexcept {
  dvec3 down;
  for (int i = 0; i < 3; ++i) {
    dvec3 half(0);
    half[i] = 0.5;
    down[i] = volume.DistanceAtSample(at - half) - volume.DistanceAtSample(at + half);
  }
  double slope = std::sqrt(Dot(down, down));
  return slope < kSlope ? normal : down / slope;
}

double EngagementReader::WeightAhead(const Active& a, const dvec3& direction) noexcept {
  double own = Dot(a.normal, direction), field = Dot(a.into, direction);
  double rate = own < field ? own : field;
  if (!(rate > a.grazing)) return 0;
  return rate >= kAheadOf ? 1 : (rate - a.grazing) / (kAheadOf - a.grazing);
}

Engagement EngagementReader::Read(const dvec3& travel) const noexcept {
  if (rule_ == EngagementRule::kBand) return ReadBand(travel);
  Engagement out;
  const dvec3 direction = Unit(travel);
  dvec3 cutting(0), shank(0);
  for (size_t i = 0; i < active_count_; ++i) {
    const Active& a = active_[i];
    double area = a.area_m2 * WeightAhead(a, direction);
    if (!(area > 0)) continue;
    if (a.shank) {
      shank += a.into * area;
      continue;
    }
    double along = Dot(a.into, direction), square = along * along * area;
    out.damping_n_s_per_m += Sym3::Outer(a.into, a.beta * area);
    out.coulomb_n += a.coulomb * square;
    out.threshold_n += a.threshold * square;
    cutting += a.into * area;
    out.area_m2 += area;
  }
  out.mean_normal = Unit(cutting + shank);
  out.shank_normal = Unit(shank);
  return out;
}

Engagement EngagementReader::ReadBand(const dvec3& travel) const noexcept {
  Engagement out;
  dvec3 cutting(0), shank(0);
  for (size_t i = 0; i < active_count_; ++i) {
    const Active& a = active_[i];
    if (!(Dot(a.normal, travel) > 0)) continue;
    if (a.shank) {
      shank += a.normal * a.area_m2;
      continue;
    }
    out.damping_n_s_per_m += Sym3::Outer(a.normal, a.beta * a.area_m2);
    cutting += a.normal * a.area_m2;
    out.area_m2 += a.area_m2;
  }
  out.mean_normal = Unit(cutting + shank);
  out.shank_normal = Unit(shank);
  return out;
}

RotationalEngagement EngagementReader::ReadRotational(const dvec3& turn) const noexcept {
  RotationalEngagement out;
  for (size_t i = 0; i < active_count_; ++i) {
    const Active& a = active_[i];
    double area = a.area_m2;
    if (rule_ == EngagementRule::kAhead) {
      area *= WeightAhead(a, Unit(glm::cross(turn, a.arm)));
      if (!(area > 0)) continue;
    }
    out.shank = out.shank || a.shank;
    out.damping_n_m_s += Sym3::Outer(glm::cross(a.arm, a.into), a.beta * area);
  }
  return out;
}

}  // namespace enamel::cutting
