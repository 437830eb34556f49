#include "common/postgres/pg_db.h"

#include <algorithm>
#include <utility>

#include "common/base/hex.h"
#include "common/base/uuid.h"
#include "common/postgres/libpq.h"
#include "common/postgres/pg_statement.h"
#include "common/postgres/pg_text.h"

namespace enamel::sql {
namespace {

using Kind = PgFailure::Kind;

std::string FirstLine(const char* words) {
  const std::string all = words == nullptr ? "" : words;
  return all.substr(0, all.find('\n'));
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

namespace {

// A socket of this machine ("/run/…", "@…"), or an address that does not leave it.
bool IsHere(const std::string& host) {
  return host.empty() || host.front() == '/' || host.front() == '@' || host == "localhost" ||
         host.starts_with("127.") || host == "::1";
}

// Of several hosts, separated by commas, one that is elsewhere; empty: none.
std::string Elsewhere(const std::string& hosts) {
  for (size_t begin = 0; begin <= hosts.size();) {
    const size_t end = std::min(hosts.find(',', begin), hosts.size());
    std::string host = hosts.substr(begin, end - begin);
    if (!IsHere(host)) return host;
    begin = end + 1;
  }
  return {};
}

// Without sslmode, libpq uses plaintext where the server has no TLS, and checks no certificate.
Status MustBePrivate(const Libpq& pq, const std::string& server) {
  char* why = nullptr;
  PQconninfoOption* const words = pq.conninfo_parse(server.c_str(), &why);
  if (words == nullptr) {
    Status bad(Code::kInvalidInput, "expected a connection string of libpq, found another: " +
                                        FirstLine(why) + "; mend it");
    pq.freemem(why);
    return bad;
  }
  std::string elsewhere, mode;
  for (const PQconninfoOption* word = words; word->keyword != nullptr; ++word) {
    const std::string name = word->keyword, value = word->val == nullptr ? "" : word->val;
    if (name == "host" || name == "hostaddr") {
      if (elsewhere.empty()) elsewhere = Elsewhere(value);
    }
    if (name == "service" && !value.empty()) elsewhere = "service " + value;
    if (name == "sslmode") mode = value;
  }
  pq.conninfo_free(words);
  if (elsewhere.empty() || mode == "verify-full") return Status::Ok();
  return Status(Code::kInvalidInput,
                "expected sslmode=verify-full for a PostgreSQL server on another machine, found " +
                    (mode.empty() ? std::string("no sslmode") : "sslmode=" + mode) + " for " +
                    elsewhere +
                    ": passwords and recordings would travel in the clear, or to anybody; add "
                    "sslmode=verify-full and sslrootcert=FILE to the connection string");
}

}  // namespace

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

Status PgDb::Connect() {
  ++connection_;
  demoted_ = false;
  set_up_ = false;
  hangs_ = false;
  failure_ = {};
  if (handle_ == nullptr) {
    // Keywords before dbname are defaults, which the server's own words replace; keywords after it
    // are not. A host that does not answer is found within two seconds (libpq's least), not when
    // TCP gives up: the next host may be the primary by now. A read-only connection also goes to
    // the primary: a standby may lack the newest commits.
    const char* const names[] = {"connect_timeout",
                                 "tcp_user_timeout",
                                 "keepalives_idle",
                                 "keepalives_interval",
                                 "keepalives_count",
                                 "target_session_attrs",
                                 "dbname",
                                 "client_encoding",
                                 "fallback_application_name",
                                 nullptr};
    const char* const values[] = {"2",
                                  "5000",
                                  "5",
                                  "2",
                                  "3",
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
  // Connecting waits, at most as long as connect_timeout says, and needs it off.
  if (pq_.set_nonblocking(handle_, 1) != 0) return Fail(nullptr);
  ENAMEL_RETURN_IF_ERROR(SetUp());
  set_up_ = true;
  return Status::Ok();
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
    failure.words = hangs_
                        ? "no answer for seconds, also not to a new connection; this one was closed"
                        : FirstLine(pq_.error_message(handle_));
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
