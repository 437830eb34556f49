#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "station/lab/cutting/tick_cost.h"

// The accuracy of cutting, compared with closed forms, and its cost.
namespace enamel::station::lab {

// One bur at one speed, cut at several voxel sizes, each with the grid at several places.
struct CuttingPlan {
  std::vector<CutCase> cases;      // their voxel size and grid are not used
  std::vector<int32_t> voxels_nm;  // coarse to fine, each half of the one before
  size_t ticks = 1000;
  int replays = 5;
  size_t grids = 8;
};
// All burs x speeds x voxel sizes, in a groove and in a plunge, turned off the grid together with
// the block so that no face is along voxels; `quick`: two burs, one speed, two sizes, the groove.
CuttingPlan DefaultCuttingPlan(bool quick);

// The grids of a plan: places in a voxel that fill it evenly, and no two of which share a
// coordinate (Kronecker sequence of the plastic number; Roberts, 2018). Shares of a voxel; the first is 0.
dvec3 GridAt(size_t i);

// What a cut differs by from the body that its bur swept (swept_body.h), with the grid at one place.
struct CutErrors {
  double removed_mm3 = 0, analytic_mm3 = 0;
  double volume = 0;  // removed / analytic - 1
  // Distance of the hole's mesh from the body, over vertices more than 1.5 voxels inside the block;
  // rims of the bur's own edges, which the mesh bevels, are included.
  double surface_mean_um = 0, surface_p95_um = 0;
  size_t vertices = 0;
  double force_mean_n = 0;
  // |mean F - reference| / |reference|, over the measured ticks: the bur's front is in the block.
  double force = 0;
};

struct CuttingFigures {
  CutCase c;
  TickCost cost;                 // on the same path
  std::vector<CutErrors> grids;  // the first with samples at whole voxels of the scene
};

// Case by case, coarse to fine. `progress` (what, done, all) may be empty. Blocks.
std::vector<CuttingFigures> MeasureCutting(
    const CuttingPlan& plan,
    const std::function<void(const std::string&, size_t, size_t)>& progress = {});

// The accuracy of a score at a voxel size: the same hand cuts a class I cavity into the built-in
// molar as a reference, and again with the mesial wall 0.3 mm and the floor 0.15 mm too deep.
struct RegionFigures {
  std::string region, unit;
  double over = 0;   // what was cut too far, as an even layer
  double error = 0;  // against the finest voxel size
};
struct ScoreFigures {
  int32_t voxel_nm = 0;
  double mb = 0;               // the whole tooth
  double realtime_factor = 0;  // of the replay
  double points = 0;           // of the score
  std::vector<RegionFigures> regions;
};
inline constexpr double kMesialExtra_m = 0.3e-3, kFloorExtra_m = 0.15e-3;

// Errors: those of the scene's builder, the replay and the metrics.
Result<std::vector<ScoreFigures>> MeasureScores(
    const std::vector<int32_t>& voxels_nm, uint64_t ticks,
    const std::function<void(const std::string&, size_t, size_t)>& progress = {});

}  // namespace enamel::station::lab
