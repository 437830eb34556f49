#pragma once

#include <algorithm>

namespace enamel {

// 0 below lo, 1 above hi, and between them a cubic without a corner at either end. Only + - * /, so equal on every
// machine. Requires: lo < hi. Thread safety: any thread. Real-time: safe.
inline double Ramp(double value, double lo, double hi) {
  const double t = std::clamp((value - lo) / (hi - lo), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace enamel
