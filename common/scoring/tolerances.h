#pragma once

#include <optional>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "common/scoring/metrics.h"

// What the restorative material changes in a rubric: schemas/score.md, "Restorative material".
// Thread safety: functions, any thread. Deterministic.
namespace enamel::scoring {

// Errors: kInvalidInput naming the member ("restorations[0].criteria[1].metric") where
// * the rubric names a material that it has no tolerances for, or only for some of the criteria
//   that depend on the material;
// * tolerances are given twice, or for a criterion or critical error that the rubric does not have.
// Maps are checked by ValidateRubric.
Status ValidateRestorations(const scene::Rubric& rubric);

// The rubric with the maps and limits of the material that it names, which count in place of its
// own. Without a material, the rubric itself. Requires: ValidateRestorations accepts it.
scene::Rubric WithTolerances(const scene::Rubric& rubric);

// A criterion about how walls lean, where the material allows them a range.
struct JudgedLean {
  double beyond_deg = 0;  // of the worst wall, beyond its range: what the criterion's map is for
  // For people: that wall's angle, and the map moved to it.
  double angle_deg = 0;
  std::vector<scene::RubricPoint> map;
};
// Empty for other criteria and other rubrics. Errors: kInvalidInput where the walls' divergence was
// not measured. Requires: `rubric` is of WithTolerances; the criterion's metric has a value.
Result<std::optional<JudgedLean>> LeanOf(const scene::Rubric& rubric,
                                         const scene::RubricCriterion& criterion,
                                         const MetricSet& metrics);

}  // namespace enamel::scoring
