#include "common/fidelity/way.h"

#include <algorithm>

namespace enamel::fidelity {
namespace {

std::vector<dvec3> RunningMean(const std::vector<dvec3>& x, size_t half) {
  std::vector<dvec3> sums(x.size() + 1, dvec3(0)), out(x.size());
  // Relative to the first one: sums of large coordinates would lose the small motion.
  for (size_t i = 0; i < x.size(); ++i) sums[i + 1] = sums[i] + (x[i] - x[0]);
  for (size_t i = 0; i < x.size(); ++i) {
    size_t reach = std::min({half, i, x.size() - 1 - i});
    out[i] = x[0] + (sums[i + reach + 1] - sums[i - reach]) / static_cast<double>(2 * reach + 1);
  }
  return out;
}

}  // namespace

// Twice, which makes a triangle of 40 ms: once leaves steps in the slope.
std::vector<dvec3> Smoothed(const std::vector<dvec3>& way) {
  return RunningMean(RunningMean(way, 10), 10);
}

dvec3 WayReader::PositionAt(double t) const {
  double at = std::clamp(t / kWayStep_s, 0.0, static_cast<double>(way_.size() - 1));
  auto i = std::min(static_cast<size_t>(at), way_.size() - 2);
  double u = at - static_cast<double>(i);
  // Catmull-Rom: the speed has no steps.
  const dvec3 &p1 = way_[i], &p2 = way_[i + 1], &p0 = i > 0 ? way_[i - 1] : p1,
              &p3 = i + 2 < way_.size() ? way_[i + 2] : p2;
  return p1 + 0.5 * u *
                  ((p2 - p0) +
                   u * ((2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) + u * (3.0 * (p1 - p2) + p3 - p0)));
}

dvec3 WayReader::SpeedAt(double t) const {
  double h = 0.5 * kWayStep_s;
  return (PositionAt(t + h) - PositionAt(t - h)) / (2 * h);
}

}  // namespace enamel::fidelity
