#pragma once

#include <cmath>
#include <optional>

#include "common/math/orientation.h"
#include "common/math/vec.h"

namespace enamel::station::sdk {

// The frame of CHAI3D, Force Dimension and Polhem, x toward the user, y to the right, z up, to the scene's
// at the seat and back.
inline dvec3 FromUserward(const dvec3& v) noexcept { return {v.y, -v.x, v.z}; }
inline dvec3 ToUserward(const dvec3& v) noexcept { return {-v.y, v.x, v.z}; }

// The rotation whose matrix has these columns; nothing: they are none of a rotation's. Lengths and angles
// may be wrong by a tenth, as a quaternion's (PolledDevice). A comparison with what is not a number fails.
inline std::optional<Quat> QuatOfColumns(const dvec3& x, const dvec3& y, const dvec3& z) noexcept {
  const auto is_unit = [](const dvec3& v) { return Dot(v, v) > 0.81 && Dot(v, v) < 1.21; };
  const auto is_right = [](const dvec3& v, const dvec3& w) { return std::abs(Dot(v, w)) < 0.1; };
  const bool is_rotation = is_unit(x) && is_unit(y) && is_unit(z) && is_right(x, y) &&
                           is_right(y, z) && is_right(z, x) && Dot(glm::cross(x, y), z) > 0;
  if (!is_rotation) return std::nullopt;
  // The largest of the four is at least 1: no division by next to nothing (Shepperd, Journal of Guidance
  // and Control 1, 1978).
  const double w = 1 + x.x + y.y + z.z, a = 1 + x.x - y.y - z.z, b = 1 - x.x + y.y - z.z,
               c = 1 - x.x - y.y + z.z;
  Quat q;
  if (w >= a && w >= b && w >= c) {
    q = {y.z - z.y, z.x - x.z, x.y - y.x, w};
  } else if (a >= b && a >= c) {
    q = {a, x.y + y.x, z.x + x.z, y.z - z.y};
  } else if (b >= c) {
    q = {x.y + y.x, b, y.z + z.y, z.x - x.z};
  } else {
    q = {z.x + x.z, y.z + z.y, c, x.y - y.x};
  }
  return q.Normalised();
}

}  // namespace enamel::station::sdk
