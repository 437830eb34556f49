#pragma once

#include <string>
#include <vector>

#include "server/http/routes.h"
#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/teaching/exercise_rows.h"

// Which exercises a caller may see, and which of them change.
namespace enamel::server::http {

// Those assigned to the caller; an admin's are all.
Result<std::vector<ExerciseRow>> VisibleExercises(const Call& call, ExerciseRows& exercises);
// The exercise {id}, if the caller may use it (own, shared, or any for an admin: CanUseExercise),
// is assigned a version of it, or has worked on it. Errors: kNotFound.
Result<ExerciseRow> VisibleExercise(const Call& call, AttemptRows& attempts_rows,
                                    ExerciseRows& exercises);
// One that the caller may change. Errors also: kForbidden with its owner.
Result<ExerciseRow> ChangeableExercise(const Call& call, AttemptRows& attempts,
                                       ExerciseRows& exercises);
// Whether the caller may put an exercise of this name. Errors: kForbidden, field "name".
Status MayUseName(const Call& call, ExerciseRows& exercises, const std::string& name);

}  // namespace enamel::server::http
