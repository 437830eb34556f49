#pragma once

#include <string_view>
#include <vector>

#include "common/scoring/measured.h"
#include "common/scoring/shape.h"

// One mistake, one deduction. A wall that is too far out is a wide outline, a deep place and tissue
// lost too. What a wall, a floor or the whole cut explains of another metric is charged once, where
// it is measured as itself: schemas/score.md, "One mistake, one deduction". Thread safety: functions, any thread.
// Deterministic.
namespace enamel::scoring {

struct CauseInputs {
  const CutSide &attempt, &reference;
  // DeviationPerVertex of the attempt's mesh (+ too deep) and of the reference's (+ left).
  const std::vector<float>&attempt_m, &reference_m;
  OpenBox target;
  double depth_m = 0, leeway_m = 0;
  const surface::DistanceQuery& reference_cut;  // the reference's cut surface
};

// What a metric is charged for, where that differs from its value.
struct Charge {
  std::string_view name;
  double value = 0;  // in the metric's unit
  // Where the rest is charged: the first of these metrics that the rubric judges. Where it judges
  // none of them, the whole value is charged. Empty: nowhere, this is more than the value.
  std::vector<std::string_view> under;
};

// Metrics whose values hardly differ from what is charged (0.02 mm, a fiftieth) are left out.
std::vector<Charge> FindCharges(const Measured& measured, const CauseInputs& inputs);

}  // namespace enamel::scoring
