#include "common/cutting/engagement.h"

#include <cmath>

namespace enamel::cutting {
namespace {

dvec3 Unit(const dvec3& v) noexcept {
  double length = std::sqrt(Dot(v, v));
  return length > 0 ? v / length : dvec3(0);
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
  add(SampleSurface(bur, 3 * voxel_m, kMaxPoints), false);
  add(SampleShank(bur, 3 * voxel_m, kMaxShankPoints), true);
  for (size_t t = 0; t < kTissueCount; ++t) {
    beta_.lateral[t] = damping.lateral[t] / kReferenceArea_m2;
    beta_.axial[t] = damping.axial[t] / kReferenceArea_m2;
  }
  active_.resize(points_.size());
}

void EngagementReader::Sample(const Volume& volume, const Pose& pose) noexcept {
  active_count_ = 0;
  shank_contact_ = false;
  const dmat3 m = pose.orientation.Matrix();
  const dvec3 tip = (pose.tip_m - volume.spec().origin_m()) / voxel_m_;
  const double reach = 0.5;  // voxels
  for (const Point& p : points_) {
    dvec3 arm = m[0] * p.position.x + m[1] * p.position.y + m[2] * p.position.z, at = tip + arm;
    if (!volume.MayBeNearer(at, reach)) continue;
    double distance = volume.DistanceAtSample(at);
    if (distance >= reach) continue;
    dvec3 n = m[0] * p.normal.x + m[1] * p.normal.y + m[2] * p.normal.z;
    double weight = distance <= 0 ? 1 : 1 - distance / reach, beta = 0;
    if (p.shank) {
      shank_contact_ = true;
    } else {
      auto t = static_cast<size_t>(volume.TissueAtSample(at + n * reach));
      beta = beta_.lateral[t] + p.axial_share * (beta_.axial[t] - beta_.lateral[t]);
    }
    active_[active_count_++] = {n, arm * voxel_m_, p.area_m2 * weight, beta, p.shank};
  }
}

Engagement EngagementReader::Read(const dvec3& travel) const noexcept {
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

Sym3 EngagementReader::ReadRotational() const noexcept {
  Sym3 out;
  for (size_t i = 0; i < active_count_; ++i) {
    const Active& a = active_[i];
    out += Sym3::Outer(glm::cross(a.arm, a.normal), a.beta * a.area_m2);
  }
  return out;
}

}  // namespace enamel::cutting
