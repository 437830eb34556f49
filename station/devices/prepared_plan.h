#pragma once

#include <functional>
#include <glm/vec2.hpp>
#include <vector>

#include "station/devices/cavity_plan.h"

namespace enamel::station {

// What a prepared tooth lacks, to be cut with an upright bur.
struct PreparedCut {
  const cutting::Volume* prepared = nullptr;
  dvec3 lo_m{0}, hi_m{0};  // around what has to go
  // How far each wall goes in, and the floor down, beyond it.
  std::function<double(const glm::dvec2& outward)> deeper_m;
  double lower_m = 0;
};

// Row by row over the lowest places where the bur's tip takes nothing that stays: layers from above,
// then once along and once across. What an upright bur does not reach, under an overhang, is left.
// Heights are known to a voxel's column: a wall is met to within a voxel.
std::vector<Move> PlanPrepared(const PreparedCut& cut, const cutting::Bur& bur,
                               const cutting::Volume& volume, const CavityPlanOptions& options);

}  // namespace enamel::station
