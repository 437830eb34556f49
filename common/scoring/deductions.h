#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/cutting/volume.h"
#include "common/scoring/mistakes/mistakes.h"
#include "common/scoring/movement/provenance.h"
#include "common/scoring/movement/strokes.h"

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

// Where a mistake lies, and what made it.
struct Deduction {
  uint32_t mistake = 0;  // its number in ScoreResult::mistakes, from 0
  bool left = false;     // true: left standing, so there is no moment; false: taken too much
  double volume_m3 = 0;  // all of it
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
  const AcceptableCut* r = nullptr;
  const cutting::Volume* attempt = nullptr;
  const FoundMistakes* found = nullptr;
  const Provenance* provenance = nullptr;
  const StrokeRecorder* strokes = nullptr;
};
// A fault that spreads over a surface has its strokes within this distance of its worst place.
inline constexpr double kNearPlace_m = 1e-3;

// One for each mistake and side of which there is any volume, in the mistakes' order, too much taken first. Requires: equal
// grids; `attempt` is what `found` was found in.
std::vector<Deduction> FindDeductions(const DeductionInputs& inputs);

}  // namespace enamel::scoring
