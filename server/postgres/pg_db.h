#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/sql/db.h"

struct pg_conn;
struct pg_result;

// The driver for PostgreSQL 15 (https://www.postgresql.org/docs/15): server/storage connects with
// it. Nothing else in the tree includes libpq's header, and the first connection opens the library.
namespace enamel::sql {

class PgStatement;
struct Libpq;

// Why PostgreSQL refused, for the code that words it.
struct PgFailure {
  enum class Kind {
    kOther,
    kNotThere,    // no connection, or it was lost
    kReplaced,    // another server has been promoted since (PgDbOptions::newest)
    kReadOnly,    // the server is a standby, or has become one
    kBusy,        // another transaction holds what is asked for, or there are too many connections
    kRepeat,      // transactions met; the same work in a new one may succeed
    kFull,        // the server's disk
    kNotAllowed,  // the user may not
    kSignIn,      // the server does not let the user in: who they are, or how they show it
    kNoDatabase,  // the server has no database of this name
    kDamaged,     // the server has found its own files damaged
    kConstraint,  // what the schema does not allow
    kTaken,       // of these: a key that must be unique is there already
    kData,        // a value that does not fit its column, or an arithmetic that overflows
    kOwnFault,    // a statement of ours that PostgreSQL cannot carry out
  };
  Kind kind = Kind::kOther;
  std::string state;     // SQLSTATE, five characters; empty: the library's own failure
  std::string words;     // PostgreSQL's, its first line
  bool opening = false;  // while it was connected
};

// One of the hosts that a connection string names, and how it answers now.
struct PgHost {
  std::string where;                                  // name and address
  std::string problem;                                // why it cannot be used; empty: it can
  PgFailure::Kind kind = PgFailure::Kind::kNotThere;  // of the problem
  bool takes_writes = false;
  int64_t timeline = 0;  // where it takes writes
  int version = 0;       // 150018
  bool tls = false;
  int64_t certificate_until_ms = 0;  // Unix time; 0: it showed none
};

// kUnavailable where trying later helps, kConflict for a constraint, kInvalidInput for data,
// kInternal for our own fault, else kStorage.
Code CodeOf(PgFailure::Kind kind);
// By SQLSTATE (Appendix A of PostgreSQL's manual).
PgFailure::Kind PgKindOf(const std::string& state);

struct PgDbOptions {
  // libpq's: "postgresql://user@host1,host2/name?target_session_attrs=read-write" or keywords. A
  // server beyond this machine needs sslmode=verify-full (kInvalidInput).
  std::string server{};
  // The schema of the tables; Migrate creates it if it does not exist. Empty: the user's own,
  // "public".
  std::string schema{};
  bool read_only = false;
  bool any = false;  // whichever server answers: to look at it
  // The program that owns these tables; another program's database is refused (kVersion).
  std::string application{};
  // Called before each statement that may write; true: the statement fails. For tests.
  std::function<bool()> fail_next{};
  // After this time without an answer, a new connection checks within two seconds whether the server
  // still answers.
  std::chrono::milliseconds patience{1000};
  // How long to try to learn whether a COMMIT was kept. A standby is promoted within this time or
  // not.
  std::chrono::milliseconds in_doubt{30'000};
  // The highest timeline of all connections that share this: each promotion begins a new one. A
  // server on an earlier timeline is not used. 0: none is known yet; null: timelines do not matter.
  std::shared_ptr<std::atomic<int64_t>> newest{};
  // Makes the status of a failure; by default PostgreSQL's words with a code.
  std::function<Status(const PgFailure&)> explain{};
};

// One connection. A call that the server does not answer ends after three seconds (`patience`, then
// two for the check): the connection is closed and counts as lost. While the server answers others,
// a call waits on: a statement until kLongest, a COMMIT or Rewrite without end. Connecting asks all
// hosts and addresses at once and takes the first that may be used, within two seconds. Not bounded
// here: looking up the name of a host.
//
// What is committed is on the server's disk, and on its synchronous standby's where
// there is one (synchronous_commit is never below "on"). Transactions of a connection that may
// write are SERIALIZABLE unless they begin with kRowLocks, then READ COMMITTED. A statement ends
// after kStatementTimeout, waiting for a lock after kLockTimeout. The next Begin, or the next
// statement outside of a transaction, replaces a lost connection. Uncommitted work is then lost,
// and must_repeat() is true. A connection that may write and finds its server read-only counts as
// lost: another server has taken over, or will.
//
// A connection that is lost during COMMIT leaves open whether the transaction was kept. So each
// transaction counts itself in a row of its connection's own (table enamel_commits, made by
// Migrate). A new connection waits for that row, which the old transaction holds until it has
// ended, and reads whether the count is there. That also holds on a standby that was promoted in
// between, where the number of a transaction (pg_xact_status) may have been given away once more.
//
// Differences to SQLite that callers may meet:
//  * A statement that fails ends the work of its transaction, up to the savepoint before it.
//  * A query's rows are all in memory from its first Next, and its columns are known from there.
//  * A text read as a number, or a number read as text, is not converted.
//
// Sources: pg_connect.cpp (which server), pg_db.cpp (connection, statements), pg_wait.cpp (deadlines), pg_transaction.cpp, pg_upkeep.cpp (schema, server's
// clock and standbys, Rewrite).
//
// Thread safety: one thread at a time. Statements are prepared once and kept, up to kMaxStatements;
// above that the least recently used one is dropped.
class PgDb final : public Db {
 public:
  static constexpr size_t kMaxStatements = 256;
  static constexpr char kStatementTimeout[] = "60s";
  static constexpr char kLockTimeout[] = "10s";
  // Longer than kStatementTimeout: then the server itself ends a statement, unless it hangs.
  static constexpr std::chrono::seconds kLongest{65};

  static Result<std::unique_ptr<PgDb>> Open(PgDbOptions options);
  // All hosts and addresses, each connected to once, within some seconds. Errors: as of Open.
  static Result<std::vector<PgHost>> Hosts(const PgDbOptions& options);
  ~PgDb() override;
  PgDb(const PgDb&) = delete;
  PgDb& operator=(const PgDb&) = delete;

  Statement* Take(const char* sql, Status& status) override;
  Status Exec(const char* sql) override;
  int64_t Changes() const override { return changes_; }
  Status Begin(Isolation isolation) override;
  Status Commit() override;
  Status RunAndCommit(std::span<Change* const> changes, bool& ran) override;
  void Rollback() override;
  bool must_repeat() const override { return must_repeat_; }
  const char* RowLock() const override { return " FOR UPDATE"; }
  const char* RowLockOrSkip() const override { return " FOR UPDATE SKIP LOCKED"; }
  bool GoesOnWithChanges() const override { return true; }
  Result<int> SchemaVersion() override;
  Status Migrate(const std::vector<Migration>& migrations) override;
  bool damaged() const override { return damaged_; }
  std::string JsonMember(const std::string& column, const std::string& member) const override;
  // Does nothing: deleted data stays in PostgreSQL's files until Rewrite.
  Status OverwriteDeleted(bool) override { return Status::Ok(); }
  // VACUUM FULL, which locks each table while it is written; then a checkpoint and a new file of
  // the log, as far as the user may request them. Archived logs, and a standby's, are older than
  // that and not touched.
  Status Rewrite() override;
  Result<uint64_t> RewriteBytes() override { return uint64_t{0}; }
  Result<std::optional<int64_t>> ClockMs() override;
  // kUnknown where there is a standby and the user is no member of pg_monitor.
  Result<Standby> StandbyOf() override;

  // Why the last statement failed; kOther without words when it did not.
  const PgFailure& failure() const { return failure_; }
  size_t kept_statements() const { return statements_.size(); }

 private:
  friend class PgStatement;
  PgDb(const Libpq& pq, PgDbOptions options);
  class Race;
  static Status MustBePrivate(const Libpq& pq, const std::string& server);
  Status Connect();
  // Whether this connection's server may be used; sets timeline_.
  Status LearnTimeline();
  // Of handle_; 0: a standby's.
  Result<int64_t> ReadTimeline();
  PgHost Described(std::string where);
  Status MustBeNewest();
  bool IsReplaced() const;
  Status SetUp();
  Status PrepareCount();
  // On the current connection, without replacing it.
  Status Run(const char* sql);
  // Sends what libpq still holds and reads until it has a result, or the connection is lost.
  void Await();
  bool IsWorthWaiting(std::chrono::steady_clock::time_point asked) const;
  bool ServerAnswers() const;  // another connection
  void GiveUp();
  // The next result of what was sent; null: there is none.
  pg_result* Answer();
  // The last result of what was sent, once it is complete; null: it was not sent.
  pg_result* LastAnswer(bool sent);
  pg_result* Ask(const std::string& sql);
  // Whether the connection can be used: it is not lost, and all of SetUp was done on it.
  bool IsThere() const;
  // Connects again where the connection is lost, or was not fully set up, and no transaction is
  // open.
  Status BeThere();
  // Whether to repeat a failed statement on a new connection: the old one had ended since its last
  // use, as after a failover, and only that statement is lost with it.
  bool IsThereAgain();
  // A COMMIT that was sent, and its answer.
  Status Ended(Status done);
  // Reads to the end of what was sent; then one statement at a time again.
  void LeavePipeline();
  int64_t RowsOf(const pg_result* result) const;  // that a statement changed
  // Whether the transaction that counted itself `number` was kept. Errors: kUnavailable (the server
  // does not answer within in_doubt).
  Result<bool> WasKept(uint64_t number);
  Result<uint64_t> CountKept();
  Result<uint64_t> ReadCount();
  Status Fail(const pg_result* result);  // of a result, or of the connection where there is none
  Status Fail(const PgFailure& failure);
  Status Told(const PgFailure& failure) const;
  bool InjectedFailure() const { return !opening_ && options_.fail_next && options_.fail_next(); }
  void DropOldest();

  const Libpq& pq_;
  const PgDbOptions options_;
  pg_conn* handle_ = nullptr;
  bool opening_ = true;
  bool set_up_ = false;   // this connection, and it can be used
  bool demoted_ = false;  // may write, and its server is read-only
  bool hangs_ = false;    // this connection was closed because its server did not answer
  bool bounded_ = true;   // by kLongest, what is being waited for
  bool in_transaction_ =
      false;                  // from Begin to Commit or Rollback, also when the connection is lost
  bool must_repeat_ = false;  // since Begin
  bool damaged_ = false;
  int64_t changes_ = 0;
  int64_t timeline_ = 0;  // of this connection's server
  // From enamel_commits: this object's row, "'\\x0123…'" in SQL, and its last transaction's count.
  std::string writer_;
  uint64_t commits_ = 0;
  bool counts_ = false;      // the table is there
  uint64_t connection_ = 0;  // how many there have been: a statement is prepared in one of them
  uint64_t names_ = 0;       // given to prepared statements
  PgFailure failure_;
  std::unordered_map<std::string, std::unique_ptr<PgStatement>> statements_;
  uint64_t uses_ = 0;
};

}  // namespace enamel::sql
