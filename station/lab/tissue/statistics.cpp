#include "station/lab/tissue/statistics.h"

#include <algorithm>
#include <cstddef>

namespace enamel::station::lab::cut {

double Quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0;
  auto at = v.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(v.size() - 1) + 0.5);
  std::nth_element(v.begin(), at, v.end());
  return *at;
}

double Student975(double n) {
  // Cornish and Fisher's expansion of Student's quantile in 1/n (Abramowitz and Stegun, 26.7.5).
  constexpr double z = 1.959964;
  double z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4 * n) + (5 * z5 + 16 * z3 + 3 * z) / (96 * n * n) +
         (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * n * n * n);
}

}  // namespace enamel::station::lab::cut
