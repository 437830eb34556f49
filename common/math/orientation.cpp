#include "common/math/orientation.h"

#include <cmath>

namespace enamel {

Quat Quat::Normalised() const noexcept {
  double n2 = x * x + y * y + z * z + w * w;
  if (!(n2 > 0) || !std::isfinite(n2)) return {};
  double n = std::sqrt(n2);
  return {x / n, y / n, z / n, w / n};
}

dmat3 Quat::Matrix() const noexcept {
  dmat3 m;
  m[0] = dvec3(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y));
  m[1] = dvec3(2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x));
  m[2] = dvec3(2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y));
  return m;
}

Quat FromQuantised(const QuantisedOrientation& q) noexcept {
  return Quat{static_cast<double>(q[0]), static_cast<double>(q[1]), static_cast<double>(q[2]),
              static_cast<double>(q[3])}
      .Normalised();
}

QuantisedOrientation ToQuantised(const Quat& q) noexcept {
  Quat n = q.Normalised();
  auto round = [](double v) { return static_cast<int16_t>(std::lround(v * 32767.0)); };
  return {round(n.x), round(n.y), round(n.z), round(n.w)};
}

}  // namespace enamel
