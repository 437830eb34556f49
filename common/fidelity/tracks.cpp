#include "common/fidelity/tracks.h"

#include <algorithm>
#include <cmath>

namespace enamel::fidelity {

dvec3 CellMiddle(const dvec3& x, double delta) {
  return (dvec3(std::floor(x.x / delta), std::floor(x.y / delta), std::floor(x.z / delta)) + 0.5) *
         delta;
}

double MinimumJerk(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * u * (10 + u * (-15 + 6 * u));
}

double MinimumJerkRate(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return 30 * u * u * (1 - u) * (1 - u);
}

dvec3 OracleStep(const dvec3& before, const dvec3& wanted, double rise, double peak) {
  // Bounds the length alone: the spring's energy F^2 / 2 Kc does not depend on its direction.
  double most = std::min(glm::length(before) + rise, peak), length = glm::length(wanted);
  return length > most ? wanted * (most / length) : wanted;
}

}  // namespace enamel::fidelity
