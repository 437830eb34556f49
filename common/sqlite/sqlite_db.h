#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/sql/db.h"

struct sqlite3;

// The driver for SQLite (https://www.sqlite.org): server/storage and station/spool open their files
// with it. Nothing else in the tree includes SQLite's header.
namespace enamel::sql {

class SqliteStatement;

// Why SQLite refused, for the code that words it.
struct SqliteFailure {
  enum class Kind {
    kOther,
    kBusy,         // another connection writes
    kInterrupted,  // by StopWaiting
    kFull,         // the disk
    kNotWritable,  // the file, its log or its folder; or it cannot be opened
    kDamaged,      // the file is no whole database
    kConstraint,   // what the schema does not allow
    kTaken,        // of these: a key that must be unique is there already
    kData,         // a value that does not fit its column, or is larger than any may be
    kOwnFault,     // a statement of ours that SQLite cannot carry out
  };
  Kind kind = Kind::kOther;
  int code = 0;          // SQLite's extended one
  std::string words;     // SQLite's
  std::string path;      // of the database
  bool opening = false;  // while it was opened or copied
};

// kUnavailable where trying later helps, kConflict for a constraint, kInvalidInput for data,
// kInternal for our own fault, else kStorage.
Code CodeOf(SqliteFailure::Kind kind);

struct SqliteDbOptions {
  enum class Mode {
    kCreate,    // read and write; made where it is not there
    kExisting,  // read and write
    kReadOnly,
  };
  Mode mode = Mode::kCreate;
  // Also a file that is cut short, or whose schema has errors, for what can be read of it.
  bool damaged = false;
  // Further PRAGMAs, for what only one of the programs needs.
  std::string setup{};
  // Marks the file as ours (PRAGMA application_id); 0: files of this kind have no mark.
  int32_t application_id = 0;
  // SQLite's name of the file layer to use; empty: its own.
  std::string vfs{};
  // Asked before each write; true: it fails. For tests.
  std::function<bool()> fail_next{};
  // Makes the status of a failure; by default "PATH: SQLite's words" with a code.
  std::function<Status(const SqliteFailure&)> explain{};
};

// One connection: WAL, synchronous=FULL (what is committed survives a power cut), foreign keys on;
// waits up to 10 s for another connection's write. Thread safety: one thread at a time, except
// where a method says otherwise. Statements are prepared once and kept, up to kMaxStatements; above
// that the least recently used one is dropped.
class SqliteDb final : public Db {
 public:
  static constexpr size_t kMaxStatements = 256;
  static constexpr std::chrono::minutes kMaxWait{15};

  static Result<std::unique_ptr<SqliteDb>> Open(const std::filesystem::path& path,
                                                SqliteDbOptions options);

  // The mark in a file's header (https://www.sqlite.org/fileformat.html), as it was when the file
  // was last checkpointed; none where there is no file or it is no database. Changes nothing, takes
  // no lock, makes no file beside it.
  //
  // Asked through SQLite and not by opening the file: POSIX drops every lock that a process has on a
  // file as soon as it closes any descriptor of it (https://www.sqlite.org/howtocorrupt.html, 2.2).
  static std::optional<int64_t> ApplicationIdIn(const std::filesystem::path& path,
                                                const std::string& vfs);
  ~SqliteDb() override;
  SqliteDb(const SqliteDb&) = delete;
  SqliteDb& operator=(const SqliteDb&) = delete;

  Statement* Take(const char* sql, Status& status) override;
  Status Exec(const char* sql) override;
  int64_t Changes() const override;
  Status Begin(Isolation isolation) override {
    return Exec(isolation == Isolation::kSnapshot ? "BEGIN" : "BEGIN IMMEDIATE");
  }
  Status Commit() override { return Exec("COMMIT"); }
  void Rollback() override;
  Result<int> SchemaVersion() override;
  Status Migrate(const std::vector<Migration>& migrations) override;
  bool damaged() const override { return damaged_; }
  std::string JsonMember(const std::string& column, const std::string& member) const override;
  Status OverwriteDeleted(bool on) override;

  // Why the last statement failed; kOther without words when it did not.
  const SqliteFailure& failure() const { return failure_; }
  // The file, or its folder, may be read only.
  bool read_only() const;
  const std::string& path() const { return path_; }
  size_t kept_statements() const { return statements_.size(); }

  // While `worth_it` returns true, up to kMaxWait, a wait does not count.
  void SetBusyWait(std::chrono::milliseconds wait, std::function<bool()> worth_it = {}) override;
  bool waits() const override { return waits_; }
  // A running Rewrite ends with kInterrupted or kUnavailable: at once, except in the last step of
  // VACUUM, which copies the new database into the log.
  void StopWaiting() override;
  // VACUUM, then EmptyLog, also where that failed.
  Status Rewrite() override;
  // In the log, and in SQLite's temporary file, which may be on the same disk, with a fiftieth for
  // the log's frames.
  Result<uint64_t> RewriteBytes() override;
  Result<std::optional<int64_t>> ClockMs() override { return std::optional<int64_t>(); }
  Result<Standby> StandbyOf() override { return Standby::kNotKept; }
  // Empties the log into the database; waits for connections that read the log or are emptying it.
  // Errors also: kUnavailable (they took longer).
  Status EmptyLog();
  // How many bytes the database takes, without its log.
  Result<uint64_t> Bytes();
  // Copies the whole database at this moment into the new file `target`, while others continue to
  // write (SQLite's backup interface, inside one read transaction, so that no write restarts it).
  // `done`: pages copied and in all. The copy is one file, synced.
  using CopyProgress = std::function<void(int done, int all)>;
  Status CopyTo(const std::filesystem::path& target, const CopyProgress& progress);

 private:
  friend class SqliteStatement;
  SqliteDb(sqlite3* handle, std::string path, SqliteDbOptions options);
  Status SetUp();
  Status UseWal();
  Status Fail();  // the handle's last error
  Status Told(const SqliteFailure& failure) const;
  void DropOldest();
  bool WaitOn(bool first);  // SQLite's question whether to try again
  bool InjectedFailure() const { return !opening_ && options_.fail_next && options_.fail_next(); }
  Result<int64_t> Pragma(const char* sql);

  sqlite3* handle_;
  const std::string path_;
  const SqliteDbOptions options_;
  bool opening_ = true;
  bool damaged_ = false;
  SqliteFailure failure_;
  std::chrono::milliseconds busy_wait_{10'000};
  std::function<bool()> worth_it_;
  std::chrono::steady_clock::time_point busy_since_{}, counted_since_{};
  std::atomic<bool> waits_{false}, stopped_{false};
  std::atomic<bool> interruptible_{false};  // Rewrite or EmptyLog is at it
  std::unordered_map<std::string, std::unique_ptr<SqliteStatement>> statements_;
  uint64_t uses_ = 0;
};

}  // namespace enamel::sql
