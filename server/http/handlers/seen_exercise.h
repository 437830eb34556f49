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
// The exercise {id}: the caller's own, shared ones and all of an admin's (CanUseExercise); else any
// version of what is assigned to the caller, and what the caller has worked on. Errors: kNotFound.
Result<ExerciseRow> VisibleExercise(const Call& call, AttemptRows& attempts_rows,
                                    ExerciseRows& exercises);
// One that is the caller's to change. Errors also: kForbidden with whose it is.
Result<ExerciseRow> ChangeableExercise(const Call& call, AttemptRows& attempts,
                                       ExerciseRows& exercises);
// Whether the caller may put an exercise of this name. Errors: kForbidden, field "name".
Status MayUseName(const Call& call, ExerciseRows& exercises, const std::string& name);

}  // namespace enamel::server::http
