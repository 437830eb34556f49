#pragma once

#include "common/base/result.h"
#include "common/scene/types.h"

// What the restorative material changes in a rubric: schemas/score.md, "Restorative material".
// Thread safety: functions, any thread. Deterministic.
namespace enamel::scoring {

// Errors: kInvalidInput naming the member ("restorations[0].critical[1].error") where the rubric names a
// material that it has no tolerances for, tolerances are given twice, or for a critical error that the rubric does not
// have; and those of ValidatePrices.
Status ValidateRestorations(const scene::Rubric& rubric);

// The rubric with the prices and limits of the material that it names, which count in place of its
// own. Without a material, the rubric itself. Requires: ValidateRestorations accepts it.
scene::Rubric WithTolerances(const scene::Rubric& rubric);

}  // namespace enamel::scoring
