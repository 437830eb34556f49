#include "common/postgres/pg_db.h"

#include <regex>
#include <thread>
#include <utility>

#include "common/base/hex.h"
#include "common/base/uuid.h"
#include "common/postgres/libpq.h"
#include "common/postgres/pg_statement.h"
#include "common/postgres/pg_text.h"
#include "common/sql/query.h"

namespace enamel::sql {
namespace {

using Kind = PgFailure::Kind;

// A number of our own choice: migrations of all programs that name it wait for each other, also
// before there is any table that could be locked.
constexpr char kMigrationLock[] = "SELECT pg_advisory_xact_lock(6291749370221)";

// As an SQL name: what is between double quotes, doubled inside.
std::string Quoted(const std::string& name) {
  std::string out = "\"";
  for (const char c : name) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

const char* BeginningOf(Isolation isolation) {
  switch (isolation) {
    case Isolation::kRowLocks:
      return "BEGIN ISOLATION LEVEL READ COMMITTED";
    case Isolation::kSnapshot:
      return "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY";
    case Isolation::kSerial:
      break;
  }
  return "BEGIN ISOLATION LEVEL SERIALIZABLE";
}

std::string FirstLine(const char* words) {
  const std::string all = words == nullptr ? "" : words;
  return all.substr(0, all.find('\n'));
}

// How many standbys a commit waits for, by synchronous_standby_names: "FIRST 2 (a, b)", "ANY 2 (a,
// b)", "2 (a, b)", or names alone, which wait for one (PostgreSQL 15, 20.6.2).
int64_t StandbysNeeded(const std::string& names) {
  if (names.find_first_not_of(" \t\n") == std::string::npos) return 0;
  static const std::regex kNumber(R"(^\s*(?:(?:first|any)\s*)?(\d{1,9})\s*\()", std::regex::icase);
  std::smatch found;
  return std::regex_search(names, found, kNumber) ? std::stoll(found[1]) : 1;
}

}  // namespace

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
  if (family == "28" || state == "42501" || state == "3D000") return Kind::kNotAllowed;
  if (family == "XX" && state != "XX000") return Kind::kDamaged;
  return Kind::kOther;
}

Code CodeOf(PgFailure::Kind kind) {
  switch (kind) {
    case Kind::kNotThere:
    case Kind::kReadOnly:
    case Kind::kBusy:
    case Kind::kRepeat:
      return Code::kUnavailable;
    case Kind::kConstraint:
    case Kind::kTaken:
      return Code::kConflict;
    default:
      return Code::kStorage;
  }
}

PgDb::PgDb(const Libpq& pq, PgDbOptions options)
    : pq_(pq), options_(std::move(options)), writer_("'\\x" + ToHex(Uuid::New().view()) + "'") {}

Result<std::unique_ptr<PgDb>> PgDb::Open(PgDbOptions options) {
  ENAMEL_ASSIGN_OR_RETURN(const Libpq* pq, LoadLibpq());
  std::unique_ptr<PgDb> db(new PgDb(*pq, std::move(options)));
  ENAMEL_RETURN_IF_ERROR(db->Connect());
  db->opening_ = false;
  return db;
}

PgDb::~PgDb() {
  statements_.clear();
  if (counts_ && commits_ > 0 && pq_.status(handle_) == CONNECTION_OK)
    pq_.clear(pq_.exec(handle_, ("DELETE FROM enamel_commits WHERE writer = " + writer_).c_str()));
  if (handle_ != nullptr) pq_.finish(handle_);
}

Status PgDb::Connect() {
  ++connection_;
  demoted_ = false;
  set_up_ = false;
  failure_ = {};
  if (handle_ == nullptr) {
    // Keywords before dbname are defaults, which the server's own words replace; keywords after it
    // are not. A host that does not answer is found within seconds, not when TCP gives up. A
    // read-only connection also goes to the primary: a standby may lack the newest commits.
    const char* const names[] = {
        "connect_timeout", "tcp_user_timeout", "keepalives_idle",           "target_session_attrs",
        "dbname",          "client_encoding",  "fallback_application_name", nullptr};
    const char* const values[] = {"5",
                                  "10000",
                                  "5",
                                  options_.read_only ? "primary" : "read-write",
                                  options_.server.c_str(),
                                  "UTF8",
                                  "enamel",
                                  nullptr};
    handle_ = pq_.connectdb_params(names, values, /*expand_dbname*/ 1);
    // Notices ("already exists, skipping") are nobody's business.
    pq_.set_notice_receiver(
        handle_, [](void*, const PGresult*) {}, nullptr);
  } else {
    pq_.reset(handle_);
  }
  if (pq_.status(handle_) != CONNECTION_OK) return Fail(nullptr);
  ENAMEL_RETURN_IF_ERROR(SetUp());
  set_up_ = true;
  return Status::Ok();
}

Status PgDb::SetUp() {
  std::string sql = "SET statement_timeout = '" + std::string(kStatementTimeout) +
                    "'; SET lock_timeout = '" + kLockTimeout +
                    "'; SET idle_in_transaction_session_timeout = '60s'; SET TimeZone = 'UTC'; "
                    // "off" and "local" could lose what the server has confirmed to a station.
                    "SELECT set_config('synchronous_commit', 'on', false) WHERE "
                    "current_setting('synchronous_commit') IN ('off', 'local'); ";
  // A reader reads statement by statement, as in SQLite; it never has to repeat.
  sql += options_.read_only ? "SET default_transaction_read_only = on; "
                            : "SET default_transaction_isolation = 'serializable'; ";
  if (!options_.schema.empty()) sql += "SET search_path = " + Quoted(options_.schema) + "; ";
  ENAMEL_RETURN_IF_ERROR(Run(sql.c_str()));
  if (options_.read_only) return Status::Ok();
  PGresult* const there =
      pq_.exec(handle_, "SELECT 1 WHERE to_regclass('enamel_commits') IS NOT NULL");
  const Status looked = pq_.result_status(there) == PGRES_TUPLES_OK ? Status::Ok() : Fail(there);
  counts_ = looked.ok() && pq_.ntuples(there) == 1;
  pq_.clear(there);
  ENAMEL_RETURN_IF_ERROR(looked);
  // After a day, the row of a killed program belongs to nobody. If another connection removes it at
  // the same moment, that is no failure.
  if (counts_) {
    pq_.clear(pq_.exec(handle_, "DELETE FROM enamel_commits WHERE at < now() - interval '1 day'"));
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
  if (IsThere() && !(demoted_ && !in_transaction_)) return Status::Ok();
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
    failure.words = FirstLine(pq_.error_message(handle_));
  }
  if (pq_.status(handle_) != CONNECTION_OK) failure.kind = Kind::kNotThere;
  failure_ = failure;
  damaged_ = damaged_ || failure.kind == Kind::kDamaged;
  if (failure.kind == Kind::kReadOnly && !options_.read_only) demoted_ = true;
  must_repeat_ = must_repeat_ || failure.kind == Kind::kRepeat ||
                 (in_transaction_ && (failure.kind == Kind::kNotThere || demoted_));
  return Told(failure);
}

Status PgDb::Told(const PgFailure& failure) const {
  if (options_.explain) return options_.explain(failure);
  return Status(CodeOf(failure.kind), "PostgreSQL: " + failure.words);
}

Status PgDb::Exec(const char* sql) {
  ENAMEL_RETURN_IF_ERROR(BeThere());
  return Run(sql);
}

Status PgDb::Run(const char* sql) {
  if (InjectedFailure()) return Status(Code::kStorage, "injected failure");
  PGresult* const result = pq_.exec(handle_, sql);
  const ExecStatusType status = pq_.result_status(result);
  Status done =
      status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK || status == PGRES_EMPTY_QUERY
          ? Status::Ok()
          : Fail(result);
  pq_.clear(result);
  return done;
}

Status PgDb::Begin(Isolation isolation) {
  in_transaction_ = false;
  must_repeat_ = false;
  std::string sql = BeginningOf(isolation);
  if (counts_ && isolation != Isolation::kSnapshot) {
    // With the first statement. If only the COMMIT took the row, a connection that checks whether
    // the transaction was kept would not wait for a COMMIT that the server has received and not
    // begun.
    sql += "; EXECUTE enamel_count (" + std::to_string(++commits_) + ")";
  }
  Status begun = Exec(sql.c_str());
  // Nothing is begun yet: on another connection, to another server perhaps. One that had ended
  // since it was used last is found out only now.
  if (!begun.ok() && (demoted_ || !IsThere())) begun = Exec(sql.c_str());
  in_transaction_ = begun.ok();
  if (!begun.ok()) Rollback();
  return begun;
}

Status PgDb::Commit() {
  ENAMEL_CHECK(in_transaction_);
  // PostgreSQL answers COMMIT with a rollback, and no failure, where a statement has failed.
  if (pq_.status(handle_) == CONNECTION_OK && pq_.transaction_status(handle_) == PQTRANS_INERROR) {
    Rollback();
    return Status(Code::kStorage, "a statement of this transaction has failed; nothing is kept");
  }
  return Ended(Exec("COMMIT"));
}

Status PgDb::RunAndCommit(std::span<Change* const> changes, bool& ran) {
  ran = true;
  if (changes.empty()) return Commit();
  ENAMEL_CHECK(in_transaction_);
  ran = false;
  std::vector<PgStatement::Call> calls;
  for (Change* change : changes) {
    change->rows = 0;
    Query q(*this, change->sql);
    change->bind(q);
    ENAMEL_RETURN_IF_ERROR(q.status());
    ENAMEL_ASSIGN_OR_RETURN(auto call, statements_.at(change->sql)->ToSendLater());
    calls.push_back(std::move(call));
  }
  if (InjectedFailure()) return Status(Code::kStorage, "injected failure");
  bool sent = pq_.enter_pipeline_mode(handle_) == 1;
  for (const PgStatement::Call& call : calls) {
    const PgArguments with(call.parameters);
    sent = sent &&
           pq_.send_query_prepared(handle_, call.name.c_str(), with.count(), with.values.data(),
                                   with.lengths.data(), with.formats.data(), /*binary*/ 1) == 1;
  }
  // After one that fails the server leaves out all that follow, also this.
  sent = sent &&
         pq_.send_query_params(handle_, "COMMIT", 0, nullptr, nullptr, nullptr, nullptr, 1) == 1 &&
         pq_.pipeline_sync(handle_) == 1;
  Status failure = sent ? Status::Ok() : Fail(nullptr);
  // By the server: then nothing is committed.
  bool refused = false;
  for (size_t i = 0; failure.ok() && i <= calls.size(); ++i) {
    PGresult* const answer = pq_.get_result(handle_);
    const ExecStatusType status = pq_.result_status(answer);
    if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) {
      refused = pq_.result_error_field(answer, PG_DIAG_SQLSTATE) != nullptr;
      failure = Fail(answer);
    } else if (i < calls.size()) {
      changes[i]->rows = RowsOf(answer);
    }
    ran = i == calls.size();
    pq_.clear(answer);
    // An answer ends with a null.
    PGresult* const end = failure.ok() ? pq_.get_result(handle_) : nullptr;
    if (end != nullptr) failure = Fail(end);
    pq_.clear(end);
  }
  // Where not all was sent the server may wait for the rest, and what it has to say is not waited
  // for.
  set_up_ = false;
  if (sent) LeavePipeline();
  if (!failure.ok()) {
    for (Change* change : changes) change->rows = 0;
    // The end of a connection may arrive after its error message.
    if (!refused || !set_up_ || pq_.status(handle_) != CONNECTION_OK) {
      // The server may have done all that was sent, even if its answer is lost.
      ran = true;
      failure_.kind = Kind::kNotThere;
      must_repeat_ = true;
      set_up_ = false;
      failure = Told(failure_);
    }
  }
  return ran ? Ended(failure) : failure;
}

void PgDb::LeavePipeline() {
  // After the answers to each statement comes a null, and after all of them what tells that it was
  // all.
  bool at_end = false;
  for (int nulls = 0; !at_end && nulls < 2;) {
    PGresult* const answer = pq_.get_result(handle_);
    at_end = answer != nullptr && pq_.result_status(answer) == PGRES_PIPELINE_SYNC;
    nulls = answer == nullptr ? nulls + 1 : 0;
    pq_.clear(answer);
  }
  set_up_ = pq_.exit_pipeline_mode(handle_) == 1;
}

int64_t PgDb::RowsOf(const pg_result* result) const {
  const std::string rows = pq_.cmd_tuples(const_cast<pg_result*>(result));
  return rows.empty() ? 0 : std::stoll(rows);
}

Status PgDb::Ended(Status done) {
  in_transaction_ = !done.ok();
  // Not lost but refused.
  if (done.ok() || failure_.kind != Kind::kNotThere) return done;
  in_transaction_ = false;
  auto kept = counts_ ? WasKept(commits_) : Result<bool>(done);
  if (!kept.ok()) {
    // It may be kept: whoever repeats it unseen may do it twice.
    must_repeat_ = false;
    return Status(Code::kUnavailable,
                  "the database's server went away as a change was to be kept, and "
                  "has not come back to tell whether it was; look before you repeat it",
                  "in_doubt");
  }
  must_repeat_ = !*kept;
  return *kept ? Status::Ok() : done;
}

Result<bool> PgDb::WasKept(uint64_t number) {
  const auto until = std::chrono::steady_clock::now() + options_.in_doubt;
  for (;;) {
    auto count = CountKept();
    if (count.ok()) return *count == number;
    if (std::chrono::steady_clock::now() >= until) return count.status();
    // A server that comes up, or a standby that is promoted, takes seconds.
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

// The old transaction may still be at its COMMIT, or have it ahead, whatever connection asks. It
// holds the row, or the key of a row that does not exist yet, so this waits for it.
Result<uint64_t> PgDb::CountKept() {
  ENAMEL_RETURN_IF_ERROR(BeThere());
  // Ends the transaction of a connection that was not lost after all.
  Rollback();
  // Not Begin, which counts.
  ENAMEL_RETURN_IF_ERROR(Exec("BEGIN ISOLATION LEVEL READ COMMITTED"));
  in_transaction_ = true;
  auto count = ReadCount();
  // A restarted primary has commits that it had not yet sent to its standby, and does not wait for
  // the standby with them. This COMMIT does: the row's lock is a change, and follows them.
  if (Status kept = count.ok() ? Run("COMMIT") : Status::Ok(); !kept.ok()) count = kept;
  Rollback();
  return count;
}

Result<uint64_t> PgDb::ReadCount() {
  ENAMEL_RETURN_IF_ERROR(Exec(("INSERT INTO enamel_commits (writer, count) VALUES (" + writer_ +
                               ", 0) ON CONFLICT DO NOTHING")
                                  .c_str()));
  Query q(*this, "SELECT count FROM enamel_commits WHERE writer = " + writer_ + " FOR UPDATE");
  if (q.Next()) return static_cast<uint64_t>(q.Int(0));
  return q.status().ok() ? Status(Code::kStorage, "enamel_commits has lost a row") : q.status();
}

void PgDb::Rollback() {
  const PgFailure why = failure_;
  in_transaction_ = false;
  const bool open =
      pq_.status(handle_) == CONNECTION_OK && pq_.transaction_status(handle_) != PQTRANS_IDLE;
  if (open) pq_.clear(pq_.exec(handle_, "ROLLBACK"));
  failure_ = why;
}

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
  if (!q.status().ok()) return q.status();
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
  for (size_t i = 0; status.ok() && i < tables.size(); ++i) {
    status = Exec(("VACUUM (FULL, ANALYZE) " + tables[i]).c_str());
  }
  // Refused to users without superuser rights: the server does both itself within minutes.
  for (const char* sql : {"CHECKPOINT", "SELECT pg_switch_wal()"}) {
    if (!status.ok()) break;
    status = Exec(sql);
    if (failure_.kind == Kind::kNotAllowed) status = Status::Ok();
  }
  const std::string again = "SET statement_timeout = '" + std::string(kStatementTimeout) + "'";
  Status back = Exec(again.c_str());
  return status.ok() ? back : status;
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
  if (!name.empty() && pq_.status(handle_) == CONNECTION_OK)
    pq_.clear(pq_.exec(handle_, ("DEALLOCATE " + name).c_str()));
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
