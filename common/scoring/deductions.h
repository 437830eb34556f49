#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/cutting/volume.h"
#include "common/scene/types.h"
#include "common/scoring/metrics.h"
#include "common/scoring/movement/provenance.h"
#include "common/scoring/movement/strokes.h"
#include "common/surface/surface.h"

// Where and when points were lost: schemas/score.md, "Deductions".
// Deterministic. Thread safety: functions, any thread.
namespace enamel::scoring {

// One stroke's part in a fault.
struct FaultStroke {
  uint32_t number = 0;  // from 1 (strokes.h)
  uint64_t first_tick = 0;
  double first_s = 0;  // since the start, gaps included
  double lasts_s = 0;  // the whole stroke
  // Volume of the fault's voxels whose centre went in it and is solid in the reference.
  double volume_m3 = 0;

  bool operator==(const FaultStroke&) const = default;
};

// One criterion's places of one kind.
struct Deduction {
  std::string criterion;  // metric
  bool left = false;      // true: left standing, so there is no moment; false: taken too much
  double volume_m3 = 0;   // all of it
  // The middle of the fault in the brick of 8 voxels that holds most of it, scene frame.
  dvec3 position_m{0};
  // Unit vector out of the tooth there: where to look at it from.
  dvec3 facing{0, 0, 1};
  // True: strokes and moments are of the fault within kNearPlace_m of position_m, because it
  // spreads over a surface. False for tissue that must not be touched at all (a neighbour, the
  // pulp): they are of the whole fault.
  bool here = false;
  // How many strokes took of it; 0 where `left`, and where it is thinner than half a voxel
  // everywhere, so that its moment is unknown.
  uint32_t stroke_count = 0;
  // The first crossing that counts; 0 without strokes.
  uint64_t first_tick = 0;
  double first_s = 0;
  // By when half of it had gone; 0 without strokes.
  uint64_t half_tick = 0;
  double half_s = 0;
  // The strokes with most of it, those first, at most kMaxStrokes; and what all of them took.
  std::vector<FaultStroke> strokes;
  double strokes_m3 = 0;

  static constexpr size_t kMaxStrokes = 8;
  bool operator==(const Deduction&) const = default;
};

struct DeductionInputs {
  const cutting::Volume* initial = nullptr;
  const cutting::Volume* attempt = nullptr;
  const cutting::Volume* reference = nullptr;
  // The reference's cut surface (CutPart in task.h); only where near and far are distinguished.
  const surface::Mesh* reference_cut = nullptr;
  double near_m = 0;  // farther than this from it is elsewhere
  const Provenance* provenance = nullptr;
  const StrokeRecorder* strokes = nullptr;
  const std::vector<WorstPlace>* places = nullptr;  // ComputeMetrics'; may be null
};
// A fault of a line or a section includes everything within this distance of its worst place.
inline constexpr double kNearPlace_m = 1e-3;

// The deductions of `criteria`, metrics that cost points, in their order: one for too much taken
// and one for too much left, where the metric has a place and there is any of it. Metrics of force,
// time and path have none. A metric with its own place (`places`) has a deduction at that place,
// even where nothing near it differs by a voxel's hundredth. Requires: equal grids.
std::vector<Deduction> FindDeductions(const scene::Scene& scene, const scene::CavityTarget& target,
                                      const std::vector<std::string>& criteria,
                                      const DeductionInputs& inputs);

}  // namespace enamel::scoring
