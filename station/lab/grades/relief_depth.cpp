#include "station/lab/grades/relief_depth.h"

#include <algorithm>
#include <cmath>

namespace enamel::station::lab {
namespace {

constexpr double kStep_m = 0.02e-3;

}  // namespace

ReliefDepth::ReliefDepth(const std::function<double(const dvec3&)>& over_m, const dvec3& middle_m,
                         double half_m)
    : lo_x_m_(middle_m.x - half_m),
      lo_y_m_(middle_m.y - half_m),
      count_(static_cast<int>(2 * half_m / kStep_m) + 1) {
  for (int j = 0; j < count_; ++j) {
    for (int i = 0; i < count_; ++i) {
      const dvec3 p(lo_x_m_ + i * kStep_m, lo_y_m_ + j * kStep_m, 0);
      const double at_0 = over_m(p), to_a_m = over_m(p + dvec3(0, 0, 1)) - at_0;
      z_m_.push_back(-at_0 / to_a_m);
    }
  }
}

int ReliefDepth::Index(double from_lo_m) const {
  return std::clamp(static_cast<int>(std::lround(from_lo_m / kStep_m)), 0, count_ - 1);
}

double ReliefDepth::Height_m(double x_m, double y_m) const {
  return z_m_[static_cast<size_t>(Index(y_m - lo_y_m_) * count_ + Index(x_m - lo_x_m_))];
}

double ReliefDepth::Depth_m(const dvec3& p, double limit_m) const {
  const double below = Height_m(p.x, p.y) - p.z;
  if (below <= 0) return below;
  if (below >= 2 * limit_m) return limit_m;
  // Points farther aside are not nearer.
  const int reach = static_cast<int>(below / kStep_m) + 1;
  const int x = Index(p.x - lo_x_m_), y = Index(p.y - lo_y_m_);
  double nearest = below * below;
  for (int j = std::max(0, y - reach); j <= std::min(count_ - 1, y + reach); ++j) {
    for (int i = std::max(0, x - reach); i <= std::min(count_ - 1, x + reach); ++i) {
      const dvec3 q(lo_x_m_ + i * kStep_m, lo_y_m_ + j * kStep_m,
                    z_m_[static_cast<size_t>(j * count_ + i)]);
      nearest = std::min(nearest, Dot(p - q, p - q));
    }
  }
  return std::min(limit_m, std::sqrt(nearest));
}

}  // namespace enamel::station::lab
