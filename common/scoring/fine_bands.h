#pragma once

#include <string>
#include <vector>

#include "common/scene/types.h"

// Bands of a rubric that are finer than a score can tell: what lies within the error of its metric
// gets points by chance. Pure functions, any thread.
namespace enamel::scoring {

struct FineBand {
  std::string metric, unit;
  double band = 0;   // the narrowest stretch of the map over which the share changes
  double error = 0;  // of the metric at this voxel size (schemas/score.md, "Task" and "Shape")

  bool operator==(const FineBand&) const = default;
};

// Of criteria whose metric is a length or an angle; volumes are known as their area is, which a
// rubric does not tell. Voxel edge in nm.
std::vector<FineBand> FineBands(const scene::Rubric& rubric, int32_t voxel_nm);

// "wall_mesial_mm: points change within 0.02 mm, and it is known to 0.025 mm at voxels of 0.1 mm;
// …".
std::string FineBandText(const FineBand& band, int32_t voxel_nm);

}  // namespace enamel::scoring
