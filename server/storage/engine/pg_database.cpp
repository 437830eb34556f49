#include "server/storage/engine/pg_database.h"

#include <utility>

#include "common/postgres/pg_db.h"
#include "common/sql/query.h"
#include "server/storage/engine/database_log.h"

namespace enamel::server {
namespace {

using PgKind = sql::PgFailure::Kind;

// What to do about it.
const char* PgAdvice(PgKind kind) {
  switch (kind) {
    case PgKind::kNotThere:
      return "the database server cannot be reached; check that PostgreSQL runs";
    case PgKind::kReplaced:
      return "the database server that answers is an earlier primary, which another has replaced; "
             "stop it, and check the addresses in database.json";
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
    case PgKind::kData:
      return "a value is outside what the database can hold; nothing was changed";
    case PgKind::kOwnFault:
    case PgKind::kOther:
      break;
  }
  return "the database failed; the log says why";
}

Status TellPg(const sql::PgFailure& failure) {
  const Code code = CodeOf(failure.kind);
  if (failure.kind == PgKind::kReplaced) {
    return Status(code, failure.words + ": " + PgAdvice(failure.kind),
                  std::string(sql::kReplacedField));
  }
  if (failure.opening) return Status(code, failure.words + ": " + PgAdvice(failure.kind));
  // A name that is taken, and transactions that meet, are everyday life.
  if (failure.kind != PgKind::kTaken && failure.kind != PgKind::kRepeat) {
    WarnOfDatabase(failure.words + " (PostgreSQL " +
                   (failure.state.empty() ? "connection" : failure.state) + ")");
  }
  return Status(code, PgAdvice(failure.kind));
}

}  // namespace

Result<std::unique_ptr<sql::Db>> OpenPgDatabase(const std::string& server,
                                                const std::string& schema, bool read_only,
                                                std::function<bool()> fail_next,
                                                std::shared_ptr<std::atomic<int64_t>> newest) {
  sql::PgDbOptions options;
  options.server = server;
  options.schema = schema;
  options.read_only = read_only;
  options.application = "enamel-store";
  options.fail_next = std::move(fail_next);
  options.newest = std::move(newest);
  options.explain = TellPg;
  ENAMEL_ASSIGN_OR_RETURN(auto db, sql::PgDb::Open(std::move(options)));
  return std::unique_ptr<sql::Db>(std::move(db));
}

Result<PgFacts> ReadPgFacts(sql::Db& db) {
  sql::Query q(db,
               "SELECT (SELECT rolsuper FROM pg_roles WHERE rolname = current_user)::int::bigint, "
               "(current_setting('fsync') = 'on' AND current_setting('full_page_writes') = "
               "'on')::int::bigint, current_setting('max_connections')::bigint, (SELECT count(*) "
               "FROM pg_stat_activity WHERE backend_type = 'client backend')");
  if (!q.Next()) return q.status();
  return PgFacts{q.Int(0) != 0, q.Int(1) != 0, q.Int(2), q.Int(3)};
}

}  // namespace enamel::server
