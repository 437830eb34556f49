#pragma once

#include <string>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "common/sql/db.h"
#include "server/storage/audit/actor.h"
#include "server/training/types.h"

// Who owns the names of exercises (ExerciseRows::ShareExercise), inside a transaction.
namespace enamel::server {

// An exercise name that nobody owns belongs to the actor from now on.
Status OwnName(sql::Db& db, const std::string& name, const Actor& by);
// A name of which no exercise is left can be anybody's again.
Status FreeUnusedName(sql::Db& db, const std::string& name, const Actor& by);
// Owner and sharing of all versions of this one's name. Errors: ExerciseRows::ShareExercise.
Status ShareName(sql::Db& db, const Uuid& exercise, const SharingEdit& edit, const Actor& by);
// What the person owns is the school's from now on.
Status GiveNamesToSchool(sql::Db& db, const Uuid& owner, const Actor& by);

}  // namespace enamel::server
