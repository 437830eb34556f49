#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/db.h"

namespace enamel::server::sqlite {

struct Migration {
  std::string name;  // "0001_initial.sql"
  std::string sql;
};
// In order; the n-th (1-based) leads to schema version n. Generated from schemas/sql.
const std::vector<Migration>& Migrations();

// Schema version of an open database, 0 when empty. Errors: kVersion when newer than this program
// or not ours at all.
Result<int> SchemaVersion(Db& db);
// Runs what is missing, each migration in a transaction of its own.
Status Migrate(Db& db);

}  // namespace enamel::server::sqlite
