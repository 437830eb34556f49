#include <regex>

#include "common/sql/query.h"
#include "server/postgres/pg_db.h"
#include "server/postgres/pg_text.h"

namespace enamel::sql {
namespace {

// A number of our own choice: migrations of all programs that name it wait for each other, also
// before there is any table that could be locked.
constexpr char kMigrationLock[] = "SELECT pg_advisory_xact_lock(6291749370221)";

// How many standbys a commit waits for, by synchronous_standby_names: "FIRST 2 (a, b)", "ANY 2 (a,
// b)", "2 (a, b)", or names alone, which wait for one (PostgreSQL 15, 20.6.2).
int64_t StandbysNeeded(const std::string& names) {
  if (names.find_first_not_of(" \t\n") == std::string::npos) return 0;
  static const std::regex kNumber(R"(^\s*(?:(?:first|any)\s*)?(\d{1,9})\s*\()", std::regex::icase);
  std::smatch found;
  return std::regex_search(names, found, kNumber) ? std::stoll(found[1]) : 1;
}

}  // namespace

Result<int> PgDb::SchemaVersion() {
  {
    Query there(*this, "SELECT to_regclass('enamel_schema') IS NOT NULL");
    if (!there.Next()) return there.status();
    if (there.Int(0) == 0) return 0;
  }
  Query q(*this, "SELECT application, version FROM enamel_schema");
  if (!q.Next()) return q.status().ok() ? Result<int>(0) : q.status();
  if (q.Text(0) != options_.application) {
    return Status(Code::kVersion, "expected tables of " + options_.application +
                                      " in this schema of PostgreSQL, found those of " + q.Text(0) +
                                      "; name another schema or database; nothing in this one was "
                                      "changed");
  }
  return static_cast<int>(q.Int(1));
}

Status PgDb::Migrate(const std::vector<Migration>& migrations) {
  // The second process must see what the first has committed: a serializable transaction would keep
  // the view from before it began to wait.
  Transaction transaction(*this, Isolation::kRowLocks);
  ENAMEL_RETURN_IF_ERROR(transaction.begun());
  ENAMEL_RETURN_IF_ERROR(Exec(kMigrationLock));
  if (!options_.schema.empty()) {
    ENAMEL_RETURN_IF_ERROR(
        Exec(("CREATE SCHEMA IF NOT EXISTS " + Quoted(options_.schema)).c_str()));
  }
  ENAMEL_RETURN_IF_ERROR(
      Exec("CREATE TABLE IF NOT EXISTS enamel_schema (application TEXT COLLATE \"C\" NOT NULL, "
           "version BIGINT NOT NULL)"));
  // One row for each connection that writes, changed with every transaction: most of a page stays
  // free for that.
  ENAMEL_RETURN_IF_ERROR(
      Exec("CREATE TABLE IF NOT EXISTS enamel_commits (writer BYTEA PRIMARY KEY, count BIGINT NOT "
           "NULL, at TIMESTAMPTZ NOT NULL DEFAULT now()) WITH (fillfactor = 10)"));
  ENAMEL_ASSIGN_OR_RETURN(const int version, SchemaVersion());
  for (const Migration& next : migrations) {
    if (next.version <= version) continue;
    if (Status done = Exec(next.sql.c_str()); !done.ok()) {
      return Status(done.code(), "migration " + next.name + ": " + done.message());
    }
  }
  if (!migrations.empty() && version < migrations.back().version) {
    ENAMEL_RETURN_IF_ERROR(Exec("DELETE FROM enamel_schema"));
    Query mark(*this, "INSERT INTO enamel_schema (application, version) VALUES (?1, ?2)");
    ENAMEL_RETURN_IF_ERROR(
        mark.BindText(options_.application).BindInt(migrations.back().version).Run());
  }
  ENAMEL_RETURN_IF_ERROR(transaction.Commit());
  if (!counts_) ENAMEL_RETURN_IF_ERROR(PrepareCount());
  counts_ = true;
  return Status::Ok();
}

std::string PgDb::JsonMember(const std::string& column, const std::string& member) const {
  return "(" + column + "::json ->> '" + member + "')";
}

Result<std::optional<int64_t>> PgDb::ClockMs() {
  // Not now(), which stands still in a transaction.
  Query q(*this, "SELECT floor(extract(epoch FROM clock_timestamp()) * 1000)::bigint");
  std::optional<int64_t> out;
  if (q.Next()) out = q.Int(0);
  ENAMEL_RETURN_IF_ERROR(q.status());
  return out;
}

Result<Standby> PgDb::StandbyOf() {
  // A user without rights to the details sees the row without them.
  Query q(*this,
          "SELECT count(*), count(sync_state), count(*) FILTER (WHERE sync_state IN ('sync', "
          "'quorum')), current_setting('synchronous_standby_names') FROM pg_stat_replication");
  if (!q.Next()) return q.status();
  const int64_t needed = StandbysNeeded(q.Text(3));
  if (q.Int(2) > 0 && q.Int(2) >= needed) return Standby::kSynchronous;
  if (q.Int(1) < q.Int(0)) return Standby::kUnknown;
  if (needed > 0) return Standby::kMissing;
  return q.Int(0) > 0 ? Standby::kBehind : Standby::kNone;
}

Status PgDb::Rewrite() {
  std::vector<std::string> tables;
  {
    // This schema's own, so that one school's erasure does not keep others waiting.
    Query q(
        *this,
        "SELECT quote_ident(tablename) FROM pg_tables WHERE schemaname = current_schema() ORDER "
        "BY tablename");
    while (q.Next()) tables.push_back(q.Text(0));
    ENAMEL_RETURN_IF_ERROR(q.status());
  }
  ENAMEL_RETURN_IF_ERROR(Exec("SET statement_timeout = 0"));
  Status status;
  bounded_ = false;
  for (size_t i = 0; status.ok() && i < tables.size(); ++i) {
    status = Exec(("VACUUM (FULL, ANALYZE) " + tables[i]).c_str());
  }
  // Refused to users without superuser rights: the server does both itself within minutes.
  for (const char* sql : {"CHECKPOINT", "SELECT pg_switch_wal()"}) {
    if (!status.ok()) break;
    status = Exec(sql);
    if (failure_.kind == PgFailure::Kind::kNotAllowed) status = Status::Ok();
  }
  bounded_ = true;
  const std::string again = "SET statement_timeout = '" + std::string(kStatementTimeout) + "'";
  Status back = Exec(again.c_str());
  return status.ok() ? back : status;
}

}  // namespace enamel::sql
