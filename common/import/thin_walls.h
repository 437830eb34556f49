#pragma once

#include <functional>
#include <optional>
#include <string>

#include "common/mesh/triangle_tree.h"

// Walls that a voxel grid does not carry: cutting::kThinnestWall_voxels says why.
namespace enamel::import {

struct ThinWalls {
  double area_mm2 = 0,
         percent = 0;   // of the surface: where the solid behind it is thinner than the limit
  double least_mm = 0;  // the thinnest that was met
  dvec3 at_mm{0};       // and where
};

// `surface`: triangles outward; `inside`: of the solid it bounds. Looks inward along the normal at places
// spread over the surface, 2 a square millimetre and at least 4000. Nothing where all walls are thicker, or
// thinner ones cover less than kMinThin_percent. Deterministic.
std::optional<ThinWalls> FindThinWalls(const mesh::TriangleTree& surface,
                                       const std::function<bool(const dvec3&)>& inside,
                                       double limit_mm);
// Less is the feather edge of a scan's margin, which cuts the surface at an acute angle.
inline constexpr double kMinThin_percent = 0.2;

// For the report, with the voxel that would carry the thinnest.
std::string Words(const ThinWalls& walls, int32_t voxel_nm);

}  // namespace enamel::import
