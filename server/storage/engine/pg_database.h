#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/sql/db.h"

// The store's tables in PostgreSQL, as the server opens them.
namespace enamel::server {

// In order; generated from schemas/sql/pg. The newest has the same number as SQLite's.
const std::vector<sql::Migration>& PgMigrations();

// A failure gives the caller the remedy, without host and PostgreSQL's words: those go to the log.
// While opening, whoever started the program sees them too. `fail_next`: PgDbOptions.
Result<std::unique_ptr<sql::Db>> OpenPgDatabase(const std::string& server,
                                                const std::string& schema, bool read_only,
                                                std::function<bool()> fail_next);

}  // namespace enamel::server
