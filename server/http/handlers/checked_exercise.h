#pragma once

#include "common/base/result.h"
#include "common/scene/types.h"
#include "server/http/routes.h"
#include "server/storage/store.h"

namespace enamel::server::http {

// The body as an exercise that this server can have attempts made of (document, scene, rubric, and
// some device profile that carries it), under a name that the caller may use. Stores nothing.
// Errors: kInvalidInput with the member; kForbidden (name); kConflict without a profile.
Result<scene::Exercise> CheckedExercise(const Call& call, Store& store);

}  // namespace enamel::server::http
