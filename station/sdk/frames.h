#pragma once

#include "common/math/orientation.h"
#include "common/math/vec.h"

namespace enamel::station::sdk {

// The frame of CHAI3D, Force Dimension and Polhem, x toward the user, y to the right, z up, to the scene's
// at the seat and back.
inline dvec3 FromUserward(const dvec3& v) noexcept { return {v.y, -v.x, v.z}; }
inline dvec3 ToUserward(const dvec3& v) noexcept { return {-v.y, v.x, v.z}; }

// The rotation whose matrix has these columns.
inline Quat QuatOfColumns(const dvec3& x, const dvec3& y, const dvec3& z) noexcept {
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
