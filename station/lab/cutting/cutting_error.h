#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "station/lab/cutting/tick_cost.h"

// The accuracy of cutting, compared with closed forms and with the finest voxel, and its cost.
namespace enamel::station::lab {

// One bur at one speed, cut at several voxel sizes.
struct CuttingPlan {
  std::vector<CutCase> cases;      // their voxel size is not used
  std::vector<int32_t> voxels_nm;  // coarse to fine
  size_t ticks = 1000;
  int replays = 5;
};
// All burs x speeds x voxel sizes, upright, and turned off the grid together with the block so that
// no face is along voxels; `quick`: two burs, one speed, two sizes.
CuttingPlan DefaultCuttingPlan(bool quick);

struct CuttingFigures {
  CutCase c;
  TickCost cost;  // on the same path
  // The slot cut by a body of revolution of profile r(z) whose axis moves from outside the block's
  // side to X behind it: integral over the depth of 2 r X + pi r^2 / 2.
  double analytic_mm3 = 0, removed_mm3 = 0;
  double volume_error = 0;  // (removed - analytic) / analytic
  // Distance of the slot's mesh from the swept body, over vertices more than 1.5 voxels inside the
  // block; rims of the bur's own edges, which the mesh bevels, are included.
  double deviation_mean_um = 0, deviation_p95_um = 0;
  size_t vertices = 0;
  double force_mean_n = 0;
  // Mean of |F - F_finest| over the measured ticks, relative to the mean of |F_finest|; 0 for the
  // finest.
  double force_error = 0;
};

// Case by case, coarse to fine. `progress` (what, done, all) may be empty. Blocks.
std::vector<CuttingFigures> MeasureCutting(
    const CuttingPlan& plan,
    const std::function<void(const std::string&, size_t, size_t)>& progress = {});

// The accuracy of a score at a voxel size: the same hand cuts a class I cavity into the built-in
// molar as a reference, and again with the mesial wall 0.3 mm and the floor 0.15 mm too deep.
struct CriterionFigures {
  std::string metric, unit;
  double value = 0;
  double error = 0;  // against the finest voxel size
};
struct ScoreFigures {
  int32_t voxel_nm = 0;
  double mb = 0;                           // the whole tooth
  double realtime_factor = 0;              // of the replay
  double points = 0;                       // of the score
  std::vector<CriterionFigures> criteria;  // the exercise's rubric
};
inline constexpr double kMesialExtra_m = 0.3e-3, kFloorExtra_m = 0.15e-3;

// Errors: those of the scene's builder, the replay and the metrics.
Result<std::vector<ScoreFigures>> MeasureScores(
    const std::vector<int32_t>& voxels_nm, uint64_t ticks,
    const std::function<void(const std::string&, size_t, size_t)>& progress = {});

}  // namespace enamel::station::lab
