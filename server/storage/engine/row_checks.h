#pragma once

#include <cstdint>
#include <string>

#include "common/base/result.h"
#include "common/sql/db.h"

// What statements leave to be asked about.
namespace enamel::server {

// kConflict from a UNIQUE constraint, in words.
Status Explain(Status status, const std::string& conflict);
// kNotFound "no WHAT" when the last statement changed nothing: SQL does not call that a failure.
Status MustHaveChanged(sql::Db& db, const std::string& what);
// kConflict with field kStale unless they are the same: of two who edit at once, the second sees
// what the first did before it is overwritten.
Status MustBeRevision(int32_t stored, int32_t seen);

}  // namespace enamel::server
