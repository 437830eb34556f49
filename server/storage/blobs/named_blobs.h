#pragma once

#include <set>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/sql/db.h"

namespace enamel::server {

// Every blob that a row names.
Result<std::set<Sha256>> NamedBlobs(sql::Db& db);

}  // namespace enamel::server
