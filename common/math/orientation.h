#pragma once

#include <array>
#include <cstdint>

#include "common/math/vec.h"

namespace enamel {

// Unit quaternion as recorded: x, y, z, w, each int16 with 32767 = 1. The core only ever sees this
// quantised form, so the station and the server start from the same bits.
using QuantisedOrientation = std::array<int16_t, 4>;
inline constexpr QuantisedOrientation kIdentityOrientation = {0, 0, 0, 32767};

// Unit quaternion, x y z w, in doubles. Not glm::dquat: its functions call libm.
struct Quat {
  double x = 0, y = 0, z = 0, w = 1;

  friend Quat operator*(const Quat& a, const Quat& b) noexcept {
    return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
            a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
  }
  Quat Conjugate() const noexcept { return {-x, -y, -z, w}; }
  Quat Normalised() const noexcept;  // The identity for a zero or non-finite quaternion.
  // Rotation matrix; columns are the rotated axes (world_from_tool).
  dmat3 Matrix() const noexcept;
};

// Normalised; an all-zero input means the identity.
Quat FromQuantised(const QuantisedOrientation& q) noexcept;
// Rounds half away from zero. For edges (devices, tests), not the core.
QuantisedOrientation ToQuantised(const Quat& q) noexcept;

}  // namespace enamel
