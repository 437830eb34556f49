#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/sql/db.h"
#include "server/postgres/pg_db.h"

// The store's tables in PostgreSQL, as the server opens them.
namespace enamel::server {

// SQLite's (schemas/sql) in PostgreSQL's words, each with what PostgreSQL has beside (schemas/sql/pg).
const std::vector<sql::Migration>& PgMigrations();
const std::vector<sql::Migration>& OwnPgMigrations();
// Errors: kInternal (a word that is in no list of pg_migrations.cpp).
Result<std::string> InPostgres(const std::string& sqlite);

// A failure gives the caller the remedy, without host and PostgreSQL's words: those go to the log.
// While opening, whoever started the program sees them too. `fail_next`, `newest`: PgDbOptions.
Result<std::unique_ptr<sql::Db>> OpenPgDatabase(const std::string& server,
                                                const std::string& schema, bool read_only,
                                                std::function<bool()> fail_next,
                                                std::shared_ptr<std::atomic<int64_t>> newest = {});

// What is wrong and what to do about it, without host and PostgreSQL's words.
const char* PgRemedy(sql::PgFailure::Kind kind);
// The same of a status of such a database, where somebody has to mend it: the server lets the user
// not in, has no such database, lacks a permission, or takes no changes. Empty: it is another
// failure.
std::string PgRemedyOf(const Status& status);

// How the server is set, as whoever looks after it wants to know.
struct PgFacts {
  bool superuser = false;  // this connection's user is
  bool durable = true;     // fsync and full_page_writes are on
  int64_t most_connections = 0, connections = 0;
};
Result<PgFacts> ReadPgFacts(sql::Db& db);

}  // namespace enamel::server
