#include "server/storage/engine/pg_database.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "common/sql/query.h"
#include "server/postgres/pg_db.h"
#include "server/storage/engine/database_log.h"

namespace enamel::server {
namespace {

using PgKind = sql::PgFailure::Kind;

// The field of a status whose cause somebody has to mend.
constexpr std::pair<PgKind, std::string_view> kToMend[] = {
    {PgKind::kReadOnly, "database_read_only"},
    {PgKind::kSignIn, "database_sign_in"},
    {PgKind::kNoDatabase, "database_name"},
    {PgKind::kNotAllowed, "database_permission"}};

std::string FieldOf(PgKind kind) {
  if (kind == PgKind::kReplaced) return std::string(sql::kReplacedField);
  const auto at = std::ranges::find(kToMend, kind, &std::pair<PgKind, std::string_view>::first);
  return at == std::end(kToMend) ? "" : std::string(at->second);
}

}  // namespace

const char* PgRemedy(PgKind kind) {
  switch (kind) {
    case PgKind::kNotThere:
      return "the database server cannot be reached; check that PostgreSQL runs";
    case PgKind::kReplaced:
      return "the database server that answers is an earlier primary, which another has replaced; "
             "stop it, and check the addresses in database.json";
    case PgKind::kReadOnly:
      return "the database server accepts no changes, because it is a standby or set to read only; "
             "name the primary in the connection string, or promote this server";
    case PgKind::kBusy:
      return "the database is busy; try again";
    case PgKind::kRepeat:
      return "another server is changing the same data; try again";
    case PgKind::kFull:
      return "the database server's disk is full; free some disk space there";
    case PgKind::kNotAllowed:
      return "the database user lacks a permission; let it own the database and its tables (ALTER "
             "DATABASE ... OWNER TO, REASSIGN OWNED)";
    case PgKind::kSignIn:
      return "the database server refuses this user or its password; check both in the connection "
             "string or password file, and the server's pg_hba.conf";
    case PgKind::kNoDatabase:
      return "the database server has no database of this name; check the name in the connection "
             "string, or create it (createdb --owner USER NAME)";
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

std::string PgRemedyOf(const Status& status) {
  const auto at =
      std::ranges::find(kToMend, status.field(), &std::pair<PgKind, std::string_view>::second);
  return at == std::end(kToMend) ? "" : PgRemedy(at->first);
}

namespace {

Status TellPg(const sql::PgFailure& failure) {
  const Code code = CodeOf(failure.kind);
  const std::string field = FieldOf(failure.kind);
  if (failure.opening || failure.kind == PgKind::kReplaced) {
    return Status(code, failure.words + ": " + PgRemedy(failure.kind), field);
  }
  // A name that is taken, and transactions that meet, are everyday life.
  if (failure.kind != PgKind::kTaken && failure.kind != PgKind::kRepeat) {
    WarnOfDatabase(failure.words + " (PostgreSQL " +
                   (failure.state.empty() ? "connection" : failure.state) + ")");
  }
  return Status(code, PgRemedy(failure.kind), field);
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
