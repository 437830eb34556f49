#include "common/math/log.h"

#include <bit>
#include <cstdint>

namespace enamel {

double NaturalLog(double x) noexcept {
  // x = m 2^e with m from sqrt(1/2) to sqrt(2), so that e ln 2 and ln m never cancel.
  constexpr uint64_t kMantissa = (uint64_t{1} << 52) - 1;
  constexpr double kSqrt2 = 1.41421356237309504880, kLn2 = 0.69314718055994530942;
  const auto bits = std::bit_cast<uint64_t>(x);
  int exponent = static_cast<int>(bits >> 52 & 0x7ff) - 1023;
  double m = std::bit_cast<double>((bits & kMantissa) | uint64_t{1023} << 52);
  if (m > kSqrt2) {
    m *= 0.5;
    ++exponent;
  }
  // ln m = 2 atanh z, z = (m - 1) / (m + 1), at most 0.172. The first term left out, z^24/25 of the
  // sum, is below 2e-20.
  const double z = (m - 1) / (m + 1), z2 = z * z;
  double sum = 0;
  for (int k = 23; k >= 1; k -= 2) sum = 1.0 / k + z2 * sum;
  return exponent * kLn2 + 2 * z * sum;
}

}  // namespace enamel
