#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"

// One interface to SQL for every engine. A driver implements Db and Statement (common/sqlite is
// one). Callers use Query (common/sql/query.h), which hides Statement.
namespace enamel::sql {

// The type of a parameter or a column: in SQLite INTEGER, REAL, TEXT, BLOB; in PostgreSQL bigint,
// double precision, text, bytea. Give the type even for NULL: PostgreSQL cannot infer it.
enum class Type { kNull, kInt, kReal, kText, kBlob };

// A prepared statement in the use of one Query. Parameters are numbered from 1, columns from 0.
// Thread safety and lifetime: the connection's.
class Statement {
 public:
  virtual ~Statement() = default;

  // The values are copied. False: Failure() says why.
  virtual bool BindInt(int place, int64_t value) = 0;
  virtual bool BindReal(int place, double value) = 0;
  virtual bool BindText(int place, std::string_view value) = 0;
  virtual bool BindBlob(int place, ByteView value) = 0;
  virtual bool BindNull(int place, Type type) = 0;

  enum class Step { kRow, kEnd, kFailed };
  virtual Step Next() = 0;
  // The error of the last call that failed.
  virtual Status Failure() const = 0;

  // Known from the first Next on.
  virtual int columns() const = 0;
  virtual std::string NameOf(int column) const = 0;
  // Of the row that Next stepped to. The engine converts a value of another type than requested.
  // NULL and a missing column read as 0 or nothing.
  virtual Type TypeOf(int column) const = 0;
  virtual int64_t Int(int column) const = 0;
  virtual double Real(int column) const = 0;
  virtual ByteView View(int column) const = 0;  // text or blob; until the next Next

  // Ends its use: forgets its row and its bound values. Nothing is called after it.
  virtual void GiveBack() = 0;
};

class Db;
class Query;

// A statement that writes, in a transaction that decides nothing by the statement's answer.
struct Change {
  std::string sql;
  std::function<void(Query&)> bind;
  // How many rows it changed, once the transaction is kept. Also 0 where the count was lost: the
  // connection broke, and a later check found that the transaction was kept.
  int64_t rows = 0;

  Status Run(Db& db);
};

// A step to one version of a schema, from the previous one in a list, or from nothing.
struct Migration {
  int version;       // the number that its name begins with
  std::string name;  // "0001_initial.sql"
  std::string sql;
};

// How a transaction interacts with others, where several may write at once.
enum class Isolation {
  // The outcome is that of all transactions run one after the other, or it ends with must_repeat().
  kSerial,
  // Each statement sees what is committed by then. For work that decides on rows it has locked
  // first (RowLock): transactions on other rows do not conflict with it, and it never has to be
  // repeated because of them.
  kRowLocks,
  // Only reads; all statements see the moment of the first.
  kSnapshot,
};

// Whether committed data is also kept elsewhere.
enum class Standby {
  kNotKept,      // the engine has none: a file
  kNone,         // a server without a standby
  kBehind,       // a standby follows, and may lack what was committed last
  kMissing,      // a commit waits for a standby, and there is none that it could wait for
  kSynchronous,  // a commit waits until a standby has it
  kUnknown,      // not told to this user
};

// Field of a failure: another server has taken the place of the only one that answers.
inline constexpr std::string_view kReplacedField = "replaced";

// One connection. Thread safety: one thread at a time. Errors: in the driver's words, with the
// codes kConflict (a constraint), kUnavailable (try again), kStorage (all else).
class Db {
 public:
  virtual ~Db() = default;

  // A statement to use until its GiveBack; null: `status` says why. For Query.
  virtual Statement* Take(const char* sql, Status& status) = 0;
  // One or several statements without parameters and results.
  virtual Status Exec(const char* sql) = 0;
  // Rows changed by the last statement.
  virtual int64_t Changes() const = 0;

  // Begins a transaction that will write, except with kSnapshot. Where only one connection can
  // write, it keeps out all others from its beginning. Transaction (below) ends it in any case.
  virtual Status Begin(Isolation isolation) = 0;
  // Ok: it is kept. Any failure: nothing of it is kept, except for kUnavailable with the field
  // "in_doubt": the connection broke at this moment and the engine did not answer in time.
  virtual Status Commit() = 0;
  // The changes in this order, then Commit. `ran`: all of them were done, and a failure is
  // Commit's. Else nothing is committed, and the caller rolls the transaction back. A server gets
  // all of it before its first answer.
  virtual Status RunAndCommit(std::span<Change* const> changes, bool& ran);
  // Does nothing where no transaction is open.
  virtual void Rollback() = 0;

  // Whether, since Begin, something failed because transactions conflicted, or because the
  // connection was lost before the end. Roll the whole transaction back and run it again: it may
  // then succeed. Always false where only one connection can write.
  virtual bool must_repeat() const { return false; }
  // Suffix for a SELECT of rows that this transaction decides on: nobody else can change them
  // before its end. Empty where nobody else can anyway.
  virtual const char* RowLock() const { return ""; }
  // The same for a SELECT that skips rows locked by others, instead of waiting for them.
  virtual const char* RowLockOrSkip() const { return ""; }
  // Whether a statement can use the rows that it changes:
  //    WITH a AS (UPDATE … RETURNING …) INSERT … SELECT … FROM a.
  virtual bool GoesOnWithChanges() const { return false; }

  // The version of the last migration that ran; 0: an empty database. Errors also: kVersion (of
  // another program).
  virtual Result<int> SchemaVersion() = 0;
  // Runs the migrations that have not run yet, in one transaction: a failure leaves the database
  // unchanged. Several processes may call it at once.
  virtual Status Migrate(const std::vector<Migration>& migrations) = 0;
  // The engine has found the database itself damaged since it was opened.
  virtual bool damaged() const = 0;

  // Travels with the connection to its next user; the connection does not use it. Not owned; null
  // at first.
  struct Companion {
    virtual ~Companion() = default;
  };
  void SetCompanion(const Companion* companion) { companion_ = companion; }
  const Companion* companion() const { return companion_; }

  // Features that every engine has, each in its own SQL.
  //
  // SQL for the text of a member of the JSON object in `column`.
  virtual std::string JsonMember(const std::string& column, const std::string& member) const = 0;
  // Whether data deleted from now on is also overwritten, so that free space does not show it. An
  // engine that cannot do this leaves it to Rewrite.
  virtual Status OverwriteDeleted(bool on) = 0;
  // Rewrites the tables, outside of a transaction, so that no deleted data is left in the
  // database's files or in the log beside them. May block others.
  virtual Status Rewrite() = 0;
  // Bytes that a rewrite takes on the caller's disk; 0: the database is on another machine.
  virtual Result<uint64_t> RewriteBytes() = 0;
  // The clock of the engine's machine, milliseconds since 1970; none: it is the caller's own.
  virtual Result<std::optional<int64_t>> ClockMs() = 0;
  virtual Result<Standby> StandbyOf() = 0;
  // How long from now on a statement waits for another process's write, where one writer keeps out
  // all others. While it waits, it calls `worth_it` on the connection's thread: as long as that
  // returns true, the time does not count.
  virtual void SetBusyWait(std::chrono::milliseconds, std::function<bool()> /*worth_it*/ = {}) {}
  // Whether a statement is waiting now because `worth_it` returned true. Any thread.
  virtual bool waits() const { return false; }
  // From now on, waits for no other process. Any thread.
  virtual void StopWaiting() {}

 private:
  const Companion* companion_ = nullptr;
};

// All of a transaction or nothing: without Commit it is rolled back.
class Transaction {
 public:
  explicit Transaction(Db& db, Isolation isolation = Isolation::kSerial)
      : db_(db), begun_(db.Begin(isolation)), open_(begun_.ok()) {}
  ~Transaction() {
    if (open_) db_.Rollback();
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  const Status& begun() const { return begun_; }
  Status Commit() {
    Status done = db_.Commit();
    open_ = !done.ok();
    return done;
  }

 private:
  Db& db_;
  Status begun_;
  bool open_;
};

}  // namespace enamel::sql
