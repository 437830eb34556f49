#include "server/postgres/pg_db.h"

#include <utility>

#include "common/base/hex.h"
#include "common/base/uuid.h"
#include "server/postgres/libpq.h"
#include "server/postgres/pg_statement.h"
#include "server/postgres/pg_text.h"

namespace enamel::sql {
using Kind = PgFailure::Kind;

PgFailure::Kind PgKindOf(const std::string& state) {
  const std::string family = state.substr(0, 2);
  if (state == "23505") return Kind::kTaken;
  if (family == "23") return Kind::kConstraint;
  // The refusal of one of our triggers.
  if (state == "P0001") return Kind::kConstraint;
  if (state == "40001" || state == "40P01") return Kind::kRepeat;
  if (state == "25006") return Kind::kReadOnly;
  if (state == "53100") return Kind::kFull;
  if (state == "55P03" || state == "57014" || family == "53") return Kind::kBusy;
  if (family == "08" || family == "57") return Kind::kNotThere;
  if (family == "28") return Kind::kSignIn;
  if (state == "3D000") return Kind::kNoDatabase;
  if (state == "42501") return Kind::kNotAllowed;
  if (family == "22") return Kind::kData;
  if (family == "42" || family == "25" || family == "26" || family == "0A") return Kind::kOwnFault;
  if (family == "XX" && state != "XX000") return Kind::kDamaged;
  return Kind::kOther;
}

Code CodeOf(PgFailure::Kind kind) {
  switch (kind) {
    case Kind::kNotThere:
    case Kind::kSignIn:
    case Kind::kNoDatabase:
    case Kind::kReplaced:
    case Kind::kReadOnly:
    case Kind::kBusy:
    case Kind::kRepeat:
      return Code::kUnavailable;
    case Kind::kConstraint:
    case Kind::kTaken:
      return Code::kConflict;
    case Kind::kData:
      return Code::kInvalidInput;
    case Kind::kOwnFault:
      return Code::kInternal;
    default:
      return Code::kStorage;
  }
}

PgDb::PgDb(const Libpq& pq, PgDbOptions options)
    : pq_(pq), options_(std::move(options)), writer_("'\\x" + ToHex(Uuid::New().view()) + "'") {}

Result<std::unique_ptr<PgDb>> PgDb::Open(PgDbOptions options) {
  ENAMEL_ASSIGN_OR_RETURN(const Libpq* pq, LoadLibpq());
  ENAMEL_RETURN_IF_ERROR(MustBePrivate(*pq, options.server));
  std::unique_ptr<PgDb> db(new PgDb(*pq, std::move(options)));
  ENAMEL_RETURN_IF_ERROR(db->Connect());
  db->opening_ = false;
  return db;
}

PgDb::~PgDb() {
  statements_.clear();
  if (counts_ && commits_ > 0 && pq_.status(handle_) == CONNECTION_OK)
    pq_.clear(Ask("DELETE FROM enamel_commits WHERE writer = " + writer_));
  if (handle_ != nullptr) pq_.finish(handle_);
}

Status PgDb::SetUp() {
  std::string sql = "SET statement_timeout = '" + std::string(kStatementTimeout) +
                    "'; SET lock_timeout = '" + kLockTimeout +
                    "'; SET idle_in_transaction_session_timeout = '15s'; SET TimeZone = 'UTC'; "
                    // "off" and "local" could lose what the server has confirmed to a station.
                    "SELECT set_config('synchronous_commit', 'on', false) WHERE "
                    "current_setting('synchronous_commit') IN ('off', 'local'); ";
  // A reader reads statement by statement, as in SQLite; it never has to repeat.
  sql += options_.read_only ? "SET default_transaction_read_only = on; "
                            : "SET default_transaction_isolation = 'serializable'; ";
  if (!options_.schema.empty()) sql += "SET search_path = " + Quoted(options_.schema) + "; ";
  ENAMEL_RETURN_IF_ERROR(Run(sql.c_str()));
  if (options_.read_only) return Status::Ok();
  PGresult* const there = Ask("SELECT 1 WHERE to_regclass('enamel_commits') IS NOT NULL");
  const Status looked = pq_.result_status(there) == PGRES_TUPLES_OK ? Status::Ok() : Fail(there);
  counts_ = looked.ok() && pq_.ntuples(there) == 1;
  pq_.clear(there);
  ENAMEL_RETURN_IF_ERROR(looked);
  // After a day, the row of a killed program belongs to nobody. If another connection removes it at
  // the same moment, that is no failure.
  if (counts_) {
    pq_.clear(Ask("DELETE FROM enamel_commits WHERE at < now() - interval '1 day'"));
    ENAMEL_RETURN_IF_ERROR(PrepareCount());
  }
  return Status::Ok();
}

// It goes with every BEGIN: planned once, and not for each commit.
Status PgDb::PrepareCount() {
  return Run(
      ("PREPARE enamel_count (bigint) AS INSERT INTO enamel_commits (writer, count) VALUES (" +
       writer_ + ", $1) ON CONFLICT (writer) DO UPDATE SET count = $1, at = now()")
          .c_str());
}

bool PgDb::IsThere() const { return pq_.status(handle_) == CONNECTION_OK && set_up_; }

Status PgDb::BeThere() {
  failure_ = {};
  if (IsThere() && (in_transaction_ || !(demoted_ || IsReplaced()))) return Status::Ok();
  // Not in the middle of a transaction: its first half is lost.
  return in_transaction_ ? Fail(nullptr) : Connect();
}

bool PgDb::IsThereAgain() {
  return options_.read_only && !in_transaction_ && !IsThere() && BeThere().ok();
}

Status PgDb::Fail(const PGresult* result) {
  PgFailure failure;
  failure.opening = opening_;
  const char* const state =
      result == nullptr ? nullptr : pq_.result_error_field(result, PG_DIAG_SQLSTATE);
  if (state != nullptr) {
    failure.state = state;
    failure.kind = PgKindOf(failure.state);
    failure.words = FirstLine(pq_.result_error_field(result, PG_DIAG_MESSAGE_PRIMARY));
  } else {
    failure.words = hangs_
                        ? "no answer for seconds, also not to a new connection; this one was closed"
                        : FirstLine(pq_.error_message(handle_));
  }
  if (pq_.status(handle_) != CONNECTION_OK) failure.kind = Kind::kNotThere;
  return Fail(failure);
}

Status PgDb::Fail(const PgFailure& failure) {
  failure_ = failure;
  damaged_ = damaged_ || failure.kind == Kind::kDamaged;
  if (failure.kind == Kind::kReadOnly && !options_.read_only) demoted_ = true;
  const bool elsewhere =
      failure.kind == Kind::kNotThere || failure.kind == Kind::kReplaced || demoted_;
  must_repeat_ = must_repeat_ || failure.kind == Kind::kRepeat || (in_transaction_ && elsewhere);
  return Told(failure);
}

Status PgDb::Told(const PgFailure& failure) const {
  if (options_.explain) return options_.explain(failure);
  return Status(CodeOf(failure.kind), "PostgreSQL: " + failure.words,
                failure.kind == Kind::kReplaced ? std::string(kReplacedField) : "");
}

Status PgDb::Exec(const char* sql) {
  ENAMEL_RETURN_IF_ERROR(BeThere());
  return Run(sql);
}

Status PgDb::Run(const char* sql) {
  if (InjectedFailure()) return Status(Code::kStorage, "injected failure");
  PGresult* const result = Ask(sql);
  const ExecStatusType status = pq_.result_status(result);
  Status done =
      status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK || status == PGRES_EMPTY_QUERY
          ? Status::Ok()
          : Fail(result);
  pq_.clear(result);
  return done;
}

void PgDb::DropOldest() {
  auto oldest = statements_.end();
  for (auto at = statements_.begin(); at != statements_.end(); ++at) {
    if (at->second->in_use()) continue;
    if (oldest == statements_.end() || at->second->last_use() < oldest->second->last_use())
      oldest = at;
  }
  if (oldest == statements_.end()) return;
  const std::string name = oldest->second->name();
  statements_.erase(oldest);
  if (!name.empty() && pq_.status(handle_) == CONNECTION_OK) pq_.clear(Ask("DEALLOCATE " + name));
}

Statement* PgDb::Take(const char* sql, Status& status) {
  status = BeThere();
  if (!status.ok()) return nullptr;
  auto at = statements_.find(sql);
  if (at == statements_.end()) {
    if (statements_.size() >= kMaxStatements) DropOldest();
    at = statements_.emplace(sql, std::make_unique<PgStatement>(*this, WithDollars(sql))).first;
  }
  PgStatement& kept = *at->second;
  // A second use would forget the first one's rows.
  ENAMEL_CHECK(!kept.busy());
  kept.Use(++uses_);
  return &kept;
}

}  // namespace enamel::sql
