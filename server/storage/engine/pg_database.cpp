#include "server/storage/engine/pg_database.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "common/postgres/pg_db.h"

namespace enamel::server {
namespace {

using PgKind = sql::PgFailure::Kind;

// What to do about it.
const char* PgAdvice(PgKind kind) {
  switch (kind) {
    case PgKind::kNotThere:
      return "the database server cannot be reached; check that PostgreSQL runs";
    case PgKind::kReadOnly:
      return "the database server accepts no changes: it is a standby; try again when another "
             "server has taken over";
    case PgKind::kBusy:
      return "the database is busy; try again";
    case PgKind::kRepeat:
      return "another server is changing the same data; try again";
    case PgKind::kFull:
      return "the database server's disk is full; free some disk space there";
    case PgKind::kNotAllowed:
      return "the database server refuses this user; check its pg_hba.conf, and that the user owns "
             "the database";
    case PgKind::kDamaged:
      return "the database is damaged, restore a backup";
    case PgKind::kConstraint:
    case PgKind::kTaken:
      return "this conflicts with what is stored: it exists already, or something it names does "
             "not exist; load it again, then try again";
    case PgKind::kOther:
      break;
  }
  return "the database failed; the log says why";
}

Status TellPg(const sql::PgFailure& failure) {
  const Code code = CodeOf(failure.kind);
  if (failure.opening) return Status(code, failure.words + ": " + PgAdvice(failure.kind));
  // A name that is taken, and transactions that meet, are everyday life.
  if (failure.kind != PgKind::kTaken && failure.kind != PgKind::kRepeat) {
    spdlog::warn("database: {} (PostgreSQL {})", failure.words,
                 failure.state.empty() ? "connection" : failure.state);
  }
  return Status(code, PgAdvice(failure.kind));
}

}  // namespace

Result<std::unique_ptr<sql::Db>> OpenPgDatabase(const std::string& server,
                                                const std::string& schema, bool read_only,
                                                std::function<bool()> fail_next) {
  sql::PgDbOptions options;
  options.server = server;
  options.schema = schema;
  options.read_only = read_only;
  options.application = "enamel-store";
  options.fail_next = std::move(fail_next);
  options.explain = TellPg;
  ENAMEL_ASSIGN_OR_RETURN(auto db, sql::PgDb::Open(std::move(options)));
  return std::unique_ptr<sql::Db>(std::move(db));
}

}  // namespace enamel::server
