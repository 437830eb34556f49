#pragma once

#include <cmath>

#include "common/math/vec.h"

namespace enamel::station {

// v, shortened to length `limit` if it is longer.
inline dvec3 Limited(const dvec3& v, double limit) noexcept {
  double length = std::sqrt(Dot(v, v));
  return length > limit ? v * (limit / length) : v;
}

}  // namespace enamel::station
