#include "station/lab/cutting/force_error.h"

#include <cmath>
#include <numbers>

#include "station/lab/cutting/cutting_error.h"

namespace enamel::station::lab {

double MeasureForceError(const cutting::Bur& bur, int32_t voxel_nm) {
  // As many as the bounds were found with. The force is steady once the bur is in.
  constexpr int kWays = 12;
  CuttingPlan plan;
  plan.voxels_nm = {voxel_nm};
  plan.ticks = 40;
  plan.replays = 0;
  plan.grids = 1;
  for (int i = 0; i < kWays; ++i) {
    CutCase c;
    c.bur = bur;
    c.oblique = true;
    c.spun_rad = 2 * std::numbers::pi * i / kWays;
    plan.cases.push_back(c);
  }
  double squares = 0;
  for (const CuttingFigures& f : MeasureCutting(plan))
    squares += f.grids[0].force * f.grids[0].force;
  return std::sqrt(squares / kWays);
}

}  // namespace enamel::station::lab
