#include <thread>

#include "common/sql/query.h"
#include "server/postgres/libpq.h"
#include "server/postgres/pg_db.h"
#include "server/postgres/pg_statement.h"

namespace enamel::sql {
namespace {

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

}  // namespace

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
  const uint64_t connection = connection_;
  Status begun = Exec(sql.c_str());
  // Nothing is begun yet: on another connection, to another server perhaps. One that had ended
  // since it was used last is found out only now.
  if (!begun.ok() && connection == connection_ && (demoted_ || !IsThere()))
    begun = Exec(sql.c_str());
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
  ENAMEL_RETURN_IF_ERROR(MustBeNewest());
  bounded_ = false;
  Status done = Exec("COMMIT");
  bounded_ = true;
  return Ended(std::move(done));
}

Status PgDb::RunAndCommit(std::span<Change* const> changes, bool& ran) {
  ran = true;
  if (changes.empty()) return Commit();
  ENAMEL_CHECK(in_transaction_);
  ran = false;
  ENAMEL_RETURN_IF_ERROR(MustBeNewest());
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
  bounded_ = false;
  for (size_t i = 0; failure.ok() && i <= calls.size(); ++i) {
    PGresult* const answer = Answer();
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
    PGresult* const end = failure.ok() ? Answer() : nullptr;
    if (end != nullptr) failure = Fail(end);
    pq_.clear(end);
  }
  bounded_ = true;
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
      failure_.kind = PgFailure::Kind::kNotThere;
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
    PGresult* const answer = Answer();
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
  if (done.ok() || failure_.kind != PgFailure::Kind::kNotThere) return done;
  in_transaction_ = false;
  auto kept = counts_ ? WasKept(commits_) : Result<bool>(done);
  if (!kept.ok()) {
    // It may be kept: whoever repeats it unseen may do it twice.
    must_repeat_ = false;
    return Status(Code::kUnavailable,
                  "the connection to the database server was lost during a commit, so it is "
                  "unknown whether the change was kept; check before you repeat it",
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
  bounded_ = false;
  if (Status kept = count.ok() ? Run("COMMIT") : Status::Ok(); !kept.ok()) count = kept;
  bounded_ = true;
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
  if (open) pq_.clear(Ask("ROLLBACK"));
  failure_ = why;
}

}  // namespace enamel::sql
