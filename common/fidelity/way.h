#pragma once

#include <vector>

#include "common/math/vec.h"

namespace enamel::fidelity {

// A way is sampled once a millisecond, from time 0.
inline constexpr double kWayStep_s = 1e-3;

// A recorded way without its reading's steps, over 20 ms: a force is compared with its differences.
std::vector<dvec3> Smoothed(const std::vector<dvec3>& way_m);

// Position and speed at any time, by cubic interpolation of the way; at rest beyond its end.
class WayReader {
 public:
  explicit WayReader(const std::vector<dvec3>& way_m) : way_(way_m) {}
  dvec3 PositionAt(double t_s) const;
  dvec3 SpeedAt(double t_s) const;
  double duration_s() const { return static_cast<double>(way_.size() - 1) * kWayStep_s; }

 private:
  const std::vector<dvec3>& way_;
};

}  // namespace enamel::fidelity
