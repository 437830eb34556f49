#pragma once

// GLM is the one vector library; doubles in the core. Right-handed frames, column vectors.
// glm::dot, cross and length are + * sqrt in a fixed order and so repeat bit for bit; glm's
// trigonometry and slerp call libm and must not appear in the core.
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace enamel {

using glm::dmat3;
using glm::dvec3;
using glm::ivec3;

inline double Dot(const dvec3& a, const dvec3& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

}  // namespace enamel
