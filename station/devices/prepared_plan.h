#pragma once

#include <functional>
#include <glm/vec2.hpp>
#include <vector>

#include "station/devices/cavity_plan.h"

namespace enamel::station {

// The material to remove to make a prepared tooth, cut with an upright bur.
struct PreparedCut {
  const cutting::Volume* prepared = nullptr;
  dvec3 lo_m{0}, hi_m{0};  // around the material to remove
  // How far beyond it each wall is cut inward, and the floor down.
  std::function<double(const glm::dvec2& outward)> deeper_m;
  double lower_m = 0;
};

// Row by row over the lowest places where the bur's tip removes nothing that stays: layers from
// above, then once along and once across. What an upright bur does not reach, under an overhang, is
// left. Heights are known to a voxel's column, so walls are met to within a voxel.
std::vector<Move> PlanPrepared(const PreparedCut& cut, const cutting::Bur& bur,
                               const cutting::Volume& volume, const CavityPlanOptions& options);

}  // namespace enamel::station
