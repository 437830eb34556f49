#pragma once

#include "common/math/vec.h"

namespace enamel::station::sdk {

// The frame of CHAI3D, Force Dimension and Polhem, x toward the user, y to the right, z up, to the scene's
// at the seat and back.
inline dvec3 FromUserward(const dvec3& v) noexcept { return {v.y, -v.x, v.z}; }
inline dvec3 ToUserward(const dvec3& v) noexcept { return {-v.y, v.x, v.z}; }

}  // namespace enamel::station::sdk
