#include "common/fidelity/way.h"

#include <algorithm>

namespace enamel::fidelity {

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
