#pragma once

#include <sqlite3.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"

// A thin, checked layer over SQLite's C interface. Only server/storage includes it.
namespace enamel::server::sqlite {

// One connection. Thread safety: one thread at a time. Statements are prepared once and kept, up to
// kMaxStatements; beyond that the one that was not used for longest goes.
class Db {
 public:
  static constexpr size_t kMaxStatements = 256;
  static constexpr std::chrono::minutes kMostWait{15};
  enum class Mode { kReadWrite, kReadOnly };
  // WAL, synchronous=FULL, foreign keys on, waits up to 10 s for another process's write.
  // `vfs`: SQLite's name of the file layer to use; empty: its own.
  static Result<std::unique_ptr<Db>> Open(const std::filesystem::path& path, Mode mode,
                                          const std::string& vfs = {},
                                          std::function<bool()> fail_next = {});
  ~Db();
  Db(const Db&) = delete;
  Db& operator=(const Db&) = delete;

  // One or several statements without results.
  Status Exec(const char* sql);
  // Rows changed by the last statement.
  int64_t Changes() const { return sqlite3_changes64(handle_); }
  // How long from now on a statement waits for another process's write. `worth_it` is asked while
  // it waits, on the connection's thread: as long as it says true, up to kMostWait, the time does
  // not count.
  void SetBusyWait(std::chrono::milliseconds wait, std::function<bool()> worth_it = {});
  // Waits for what `worth_it` says is worth it. Any thread.
  bool waits() const { return waits_; }
  // From now on no other process is waited for, and what Rewrite and EmptyLog are at ends with
  // kUnavailable: at once, but for Rewrite's last step, which copies the new database into the log.
  // Any thread.
  void StopWaiting();
  // Writes the whole database anew (VACUUM). What it wrote when it fails may stay in the log until
  // that is emptied.
  Status Rewrite();
  // Empties the log into the database; waits for who reads what is in it, and for who empties it
  // already. Errors also: kUnavailable (they took longer).
  Status EmptyLog();
  // Ends the open transaction, if SQLite has not done so itself.
  void Rollback();
  // Copies the whole database as it is at this moment into the new file `target`, while others go
  // on writing (SQLite's backup interface, inside one read transaction, so that no write restarts
  // it). `done`: pages copied and in all. The copy is one file, synced.
  using CopyProgress = std::function<void(int done, int all)>;
  Status CopyTo(const std::filesystem::path& target, const CopyProgress& progress);
  // The last failure as a Status for whoever asked; says what to do where that is known. Path and
  // SQLite's words go to the log.
  Status Error() const;
  // SQLite has found the file itself damaged since it was opened.
  bool damaged() const { return damaged_; }
  const std::string& path() const { return path_; }
  size_t kept_statements() const { return statements_.size(); }

 private:
  friend class Query;
  struct Kept {
    sqlite3_stmt* statement = nullptr;
    int users = 0;
    uint64_t last_use = 0;
  };
  Db(sqlite3* handle, std::string path, std::function<bool()> fail_next)
      : handle_(handle), path_(std::move(path)), fail_next_(std::move(fail_next)) {}
  Kept* Take(const char* sql, Status& status);
  void DropOldest();
  bool WaitOn(bool first);  // SQLite's question whether to try again
  bool InjectedFailure() const { return fail_next_ && fail_next_(); }

  sqlite3* handle_;
  std::string path_;
  std::function<bool()> fail_next_;
  mutable bool damaged_ = false;
  std::chrono::milliseconds busy_wait_{10'000};
  std::function<bool()> worth_it_;
  std::chrono::steady_clock::time_point busy_since_{}, counted_since_{};
  std::atomic<bool> waits_{false}, stopped_{false};
  std::atomic<bool> interruptible_{false};  // Rewrite or EmptyLog is at it
  std::unordered_map<std::string, Kept> statements_;
  uint64_t uses_ = 0;
};

// One use of a prepared statement. ?1 is always the tenant; Bind fills ?2, ?3, … in order.
//   Query q(db, "SELECT name FROM people WHERE tenant = ?1 AND id = ?2");
//   q.Bind(id);
//   if (q.Next()) … q.Text(0) …
// A failure at any point makes Next() false and stays in status().
class Query {
 public:
  enum NoTenant { kNoTenant };
  Query(Db& db, const char* sql);
  Query(Db& db, const std::string& sql) : Query(db, sql.c_str()) {}
  Query(Db& db, const char* sql, NoTenant);
  ~Query();
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  Query& Bind(int64_t value);
  Query& Bind(double value);
  Query& Bind(const std::string& value);
  Query& Bind(ByteView value);
  Query& Bind(const Bytes& value) { return Bind(ByteView(value)); }
  Query& Bind(const Uuid& value) { return Bind(value.view()); }
  Query& Bind(const Sha256& value) { return Bind(value.view()); }
  Query& BindNull();
  // None: NULL.
  Query& Bind(const std::optional<Uuid>& value) { return value ? Bind(*value) : BindNull(); }

  // Steps to the next row; false at the end or on failure.
  bool Next();
  // Runs a statement that returns no rows.
  Status Run();
  const Status& status() const { return status_; }

  int64_t Int(int column) const { return sqlite3_column_int64(statement_, column); }
  double Real(int column) const { return sqlite3_column_double(statement_, column); }
  bool IsNull(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  std::string Text(int column) const;
  Bytes Blob(int column) const;
  Uuid Id(int column) const;      // zero when NULL
  Sha256 Hash(int column) const;  // zero when NULL

 private:
  ByteView View(int column) const;
  void Check(int rc);

  Db& db_;
  Db::Kept* kept_ = nullptr;
  sqlite3_stmt* statement_ = nullptr;
  int next_parameter_ = 1;
  Status status_;
};

// Milliseconds since the epoch, now.
int64_t NowMs();

}  // namespace enamel::server::sqlite
