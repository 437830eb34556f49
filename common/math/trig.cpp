#include "common/math/trig.h"

#include <cmath>

namespace enamel {

SinCos SinCosOfTurns(double turns) noexcept {
  // Reduce to |t| <= 1/8 turn around the nearest quarter, then Taylor series: x <= pi/4, the first
  // term left out is x^20/20! < 4e-21.
  int quarter = static_cast<int>(turns * 4 + 0.5);
  double x = (turns - quarter * 0.25) * 6.28318530717958647692;
  double x2 = x * x;
  double s = 1, c = 1;
  for (int k = 18; k >= 2; k -= 2) {
    s = 1 - s * x2 / (k * (k + 1));
    c = 1 - c * x2 / (k * (k - 1));
  }
  s *= x;
  switch (quarter & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double ArcTan(double slope) noexcept {
  // atan x = 2 atan(x / (1 + sqrt(1 + x^2))): three times makes it at most tan(pi/16) = 0.199. Then
  // the series x - x^3/3 + ..., of which the first term left out, x^25/25, is below 2e-19.
  constexpr int kHalvings = 3;
  for (int i = 0; i < kHalvings; ++i) slope /= 1 + std::sqrt(1 + slope * slope);
  const double x2 = slope * slope;
  double sum = 0;
  for (int k = 23; k >= 1; k -= 2) sum = 1.0 / k - x2 * sum;
  return (1 << kHalvings) * slope * sum;
}

}  // namespace enamel
