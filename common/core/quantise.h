#pragma once

#include <array>
#include <cstdint>

#include "common/math/vec.h"

// How the core rounds what is recorded. Any thread, real-time safe.
namespace enamel::core {

// Rounds half away from zero and saturates.
inline int32_t Quantise(double v) noexcept {
  if (!(v > -2147483647.0)) return -2147483647;
  if (!(v < 2147483647.0)) return 2147483647;
  return static_cast<int32_t>(v < 0 ? v - 0.5 : v + 0.5);
}

inline std::array<int32_t, 3> Quantise(const dvec3& v, double unit) noexcept {
  return {Quantise(v.x / unit), Quantise(v.y / unit), Quantise(v.z / unit)};
}

}  // namespace enamel::core
