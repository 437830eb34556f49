#include "common/cutting/engagement.h"

#include <cmath>

namespace enamel::cutting {

EngagementReader::EngagementReader(const Bur& bur, double voxel_m,
                                   const std::array<double, kTissueCount>& damping_n_s_per_m)
    : points_(SampleSurface(bur, 3 * voxel_m, kMaxPoints)), voxel_m_(voxel_m) {
  for (size_t t = 0; t < kTissueCount; ++t) beta_[t] = damping_n_s_per_m[t] / kReferenceArea_m2;
  active_.resize(points_.size());
}

void EngagementReader::Sample(const Volume& volume, const Pose& pose) noexcept {
  active_count_ = 0;
  dmat3 m = pose.orientation.Matrix();
  double reach = 0.5 * voxel_m_;
  for (const SurfacePoint& p : points_) {
    dvec3 arm = m[0] * p.position_m.x + m[1] * p.position_m.y + m[2] * p.position_m.z;
    double distance = volume.DistanceAt_m(pose.tip_m + arm);
    if (distance >= reach) continue;
    dvec3 n = m[0] * p.normal.x + m[1] * p.normal.y + m[2] * p.normal.z;
    double weight = distance <= 0 ? 1 : 1 - distance / reach;
    Tissue tissue = volume.TissueAtPoint(pose.tip_m + arm + n * reach);
    active_[active_count_++] = {n, arm, p.area_m2 * weight, beta_[static_cast<size_t>(tissue)]};
  }
}

Engagement EngagementReader::Read(const dvec3& travel) const noexcept {
  Engagement out;
  dvec3 normal_sum(0);
  for (size_t i = 0; i < active_count_; ++i) {
    const Active& a = active_[i];
    if (!(Dot(a.normal, travel) > 0)) continue;
    out.damping_n_s_per_m += Sym3::Outer(a.normal, a.beta * a.area_m2);
    normal_sum += a.normal * a.area_m2;
    out.area_m2 += a.area_m2;
  }
  double length = std::sqrt(Dot(normal_sum, normal_sum));
  if (length > 0) out.mean_normal = normal_sum / length;
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
