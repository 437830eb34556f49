#pragma once

#include <string>
#include <vector>

#include "server/http/routes.h"
#include "server/storage/parts.h"

// Which exercises a caller may see, and which of them change.
namespace enamel::server::http {

// Those assigned to the caller; an admin's are all.
Result<std::vector<ExerciseRow>> VisibleExercises(const Call& call, ContentStore& store);
// The exercise {id}: the caller's own, shared ones and all of an admin's (CanUseExercise); else any
// version of what is assigned to the caller, and what the caller has worked on. Errors: kNotFound.
Result<ExerciseRow> VisibleExercise(const Call& call, Parts<ContentStore, AttemptStore> store);
// One that is the caller's to change. Errors also: kForbidden with whose it is.
Result<ExerciseRow> ChangeableExercise(const Call& call, Parts<ContentStore, AttemptStore> store);
// Whether the caller may put an exercise of this name. Errors: kForbidden, field "name".
Status MayUseName(const Call& call, ContentStore& store, const std::string& name);

}  // namespace enamel::server::http
