#pragma once

#include <set>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/sql/db.h"

namespace enamel::server {

// Deletes attempts with all that hangs on them (chunks, evidence, jobs, references); adds the blobs
// they named to `blobs`. Others' scores that were compared with them stay, without naming them.
Status DeleteAttempts(sql::Db& db, const std::vector<Uuid>& attempts, std::set<Sha256>& blobs);

}  // namespace enamel::server
