#include "common/sqlite/sqlite_db.h"

#include <sqlite3.h>

#include <chrono>
#include <thread>
#include <utility>

#include "common/sql/query.h"
#include "common/sqlite/sqlite_statement.h"

namespace enamel::sql {
namespace {

// Between two looks whether another process still keeps the database.
constexpr std::chrono::milliseconds kFirstLook{1}, kNextLook{20};
// Steps of SQLite's machine between two checks whether to continue.
constexpr int kStepsAtOnce = 10'000;

// https://www.sqlite.org/rescode.html: the low byte is the primary code.
SqliteFailure::Kind KindOf(int code) {
  using Kind = SqliteFailure::Kind;
  if (code == SQLITE_CONSTRAINT_UNIQUE || code == SQLITE_CONSTRAINT_PRIMARYKEY) return Kind::kTaken;
  switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return Kind::kBusy;
    case SQLITE_INTERRUPT:
      return Kind::kInterrupted;
    case SQLITE_FULL:
      return Kind::kFull;
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return Kind::kNotWritable;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return Kind::kDamaged;
    case SQLITE_CONSTRAINT:
      return Kind::kConstraint;
    case SQLITE_TOOBIG:
    case SQLITE_MISMATCH:
      return Kind::kData;
    case SQLITE_ERROR:
    case SQLITE_RANGE:
    case SQLITE_MISUSE:
      return Kind::kOwnFault;
    default:
      return Kind::kOther;
  }
}

SqliteFailure FailureOf(sqlite3* handle, const std::string& path, bool opening) {
  const int code = sqlite3_extended_errcode(handle);
  return {KindOf(code), code, sqlite3_errmsg(handle), path, opening};
}

}  // namespace

Code CodeOf(SqliteFailure::Kind kind) {
  using Kind = SqliteFailure::Kind;
  if (kind == Kind::kBusy || kind == Kind::kInterrupted) return Code::kUnavailable;
  if (kind == Kind::kData) return Code::kInvalidInput;
  if (kind == Kind::kOwnFault) return Code::kInternal;
  // Nothing is broken: the request contradicts the stored data.
  return kind == Kind::kConstraint || kind == Kind::kTaken ? Code::kConflict : Code::kStorage;
}

SqliteDb::SqliteDb(sqlite3* handle, std::string path, SqliteDbOptions options)
    : handle_(handle), path_(std::move(path)), options_(std::move(options)) {}

Result<std::unique_ptr<SqliteDb>> SqliteDb::Open(const std::filesystem::path& path,
                                                 SqliteDbOptions options) {
  using Mode = SqliteDbOptions::Mode;
  sqlite3* handle = nullptr;
  // NOMUTEX: a connection is one thread's at a time, so SQLite need not lock.
  const int flags = options.mode == Mode::kReadOnly ? SQLITE_OPEN_READONLY
                    : options.mode == Mode::kCreate ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE
                                                    : SQLITE_OPEN_READWRITE;
  const std::string vfs = options.vfs;
  const int rc = sqlite3_open_v2(path.c_str(), &handle, flags | SQLITE_OPEN_NOMUTEX,
                                 vfs.empty() ? nullptr : vfs.c_str());
  // From here on its destructor closes the handle, which SQLite gives also when it fails.
  std::unique_ptr<SqliteDb> db(new SqliteDb(handle, path.string(), std::move(options)));
  if (rc != SQLITE_OK) return db->Fail();
  ENAMEL_RETURN_IF_ERROR(db->SetUp());
  db->opening_ = false;
  return db;
}

std::optional<int64_t> SqliteDb::ApplicationIdIn(const std::filesystem::path& path,
                                                 const std::string& vfs) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  // Signs that mean something in a URI are written by number.
  std::string uri = "file:";
  for (char c : std::filesystem::absolute(path).string()) {
    if (c == '?' || c == '#' || c == '%') {
      uri += c == '?' ? "%3f" : c == '#' ? "%23" : "%25";
    } else {
      uri += c;
    }
  }
  uri += "?immutable=1";
  sqlite3* handle = nullptr;
  sqlite3_stmt* statement = nullptr;
  std::optional<int64_t> id;
  if (sqlite3_open_v2(uri.c_str(), &handle,
                      SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX,
                      vfs.empty() ? nullptr : vfs.c_str()) == SQLITE_OK &&
      sqlite3_prepare_v2(handle, "PRAGMA application_id", -1, &statement, nullptr) == SQLITE_OK &&
      sqlite3_step(statement) == SQLITE_ROW) {
    id = sqlite3_column_int64(statement, 0);
  }
  sqlite3_finalize(statement);
  sqlite3_close(handle);
  return id;
}

Status SqliteDb::SetUp() {
  sqlite3_extended_result_codes(handle_, 1);
  sqlite3_busy_handler(
      handle_,
      [](void* db, int count) { return static_cast<SqliteDb*>(db)->WaitOn(count == 0) ? 1 : 0; },
      this);
  if (options_.damaged) {
    // With writable_schema, SQLite skips what it cannot read of the schema.
    return Exec("PRAGMA writable_schema = ON; SELECT count(*) FROM sqlite_schema");
  }
  if (options_.mode == SqliteDbOptions::Mode::kReadOnly) return Exec("PRAGMA query_only = 1");
  ENAMEL_RETURN_IF_ERROR(UseWal());
  ENAMEL_RETURN_IF_ERROR(Exec("PRAGMA synchronous = FULL; PRAGMA foreign_keys = 1"));
  return Exec(options_.setup.c_str());
}

// Two processes that switch a new file to WAL at once: SQLite tells one that it is locked without
// asking the busy handler.
Status SqliteDb::UseWal() {
  for (bool first = true;; first = false) {
    const int rc = sqlite3_exec(handle_, "PRAGMA journal_mode = WAL", nullptr, nullptr, nullptr);
    if (rc == SQLITE_OK) return Status::Ok();
    if ((rc & 0xff) != SQLITE_BUSY || !WaitOn(first)) return Fail();
  }
}

SqliteDb::~SqliteDb() {
  // Before the handle: while a statement is left, SQLite keeps the connection open behind our back.
  statements_.clear();
  sqlite3_close_v2(handle_);
}

Status SqliteDb::Exec(const char* sql) {
  failure_ = {};
  if (InjectedFailure()) return Status(Code::kStorage, "injected failure");
  int rc = sqlite3_exec(handle_, sql, nullptr, nullptr, nullptr);
  // The handler only learns of tries, not of the success after them.
  waits_ = false;
  return rc == SQLITE_OK ? Status::Ok() : Fail();
}

int64_t SqliteDb::Changes() const { return sqlite3_changes64(handle_); }

bool SqliteDb::read_only() const { return sqlite3_db_readonly(handle_, "main") == 1; }

void SqliteDb::SetBusyWait(std::chrono::milliseconds wait, std::function<bool()> worth_it) {
  busy_wait_ = wait;
  worth_it_ = std::move(worth_it);
}

bool SqliteDb::WaitOn(bool first) {
  const auto now = std::chrono::steady_clock::now();
  if (first) busy_since_ = counted_since_ = now;
  const bool waited = waits_;
  waits_ = worth_it_ && now - busy_since_ < kMaxWait && worth_it_();
  // After a wait that was worth it, a statement still has its full usual time.
  if (waits_ || waited) counted_since_ = now;
  if (stopped_ || now - counted_since_ >= busy_wait_) return false;
  std::this_thread::sleep_for(first ? kFirstLook : kNextLook);
  return true;
}

void SqliteDb::StopWaiting() {
  stopped_ = true;
  if (interruptible_) sqlite3_interrupt(handle_);
}

// The question between steps makes sure of an end that was asked for just before the beginning.
Status SqliteDb::Rewrite() {
  sqlite3_progress_handler(
      handle_, kStepsAtOnce, [](void* db) { return static_cast<SqliteDb*>(db)->stopped_ ? 1 : 0; },
      this);
  interruptible_ = true;
  Status rewritten = Exec("VACUUM");
  interruptible_ = false;
  sqlite3_progress_handler(handle_, 0, nullptr, nullptr);
  // Also after a failure: rewritten data must not stay in the log.
  Status emptied = EmptyLog();
  return rewritten.ok() ? emptied : rewritten;
}

Result<uint64_t> SqliteDb::RewriteBytes() {
  ENAMEL_ASSIGN_OR_RETURN(const uint64_t bytes, Bytes());
  return 2 * bytes + bytes / 50;
}

// SQLite waits for readers, and not for another connection that empties the log.
Status SqliteDb::EmptyLog() {
  // The same patience as for another's write.
  const auto until = std::chrono::steady_clock::now() + busy_wait_;
  Status status;
  bool busy = true;
  interruptible_ = true;
  while (status.ok() && busy && !stopped_) {
    {
      Query q(*this, "PRAGMA wal_checkpoint(TRUNCATE)");
      busy = q.Next() && q.Int(0) != 0;
      status = q.status();
    }
    if (std::chrono::steady_clock::now() >= until) break;
    if (busy) std::this_thread::sleep_for(kNextLook);
  }
  interruptible_ = false;
  if (!status.ok() || !busy) return status;
  return Status(Code::kUnavailable,
                stopped_ ? "the program is ending before the database's log is empty"
                         : "another program reads what is in the database's log, or is about to "
                           "empty it");
}

Result<uint64_t> SqliteDb::Bytes() {
  ENAMEL_ASSIGN_OR_RETURN(const int64_t pages, Pragma("PRAGMA page_count"));
  ENAMEL_ASSIGN_OR_RETURN(const int64_t page_bytes, Pragma("PRAGMA page_size"));
  return static_cast<uint64_t>(pages * page_bytes);
}

void SqliteDb::Rollback() {
  // SQLite ends a transaction itself after some failures (a full disk, for one).
  if (sqlite3_get_autocommit(handle_) == 0)
    sqlite3_exec(handle_, "ROLLBACK", nullptr, nullptr, nullptr);
}

Status SqliteDb::CopyTo(const std::filesystem::path& target, const CopyProgress& progress) {
  constexpr int kPagesAtOnce = 4096;
  sqlite3* copy = nullptr;
  int rc =
      sqlite3_open_v2(target.c_str(), &copy, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
  sqlite3_backup* backup = nullptr;
  // The count is what takes the snapshot: BEGIN alone waits for the first read.
  Status begun = Exec("BEGIN; SELECT count(*) FROM sqlite_schema");
  if (rc == SQLITE_OK && begun.ok()) backup = sqlite3_backup_init(copy, "main", handle_, "main");
  do {
    rc = backup == nullptr ? SQLITE_ERROR : sqlite3_backup_step(backup, kPagesAtOnce);
    if (backup != nullptr && progress) {
      int all = sqlite3_backup_pagecount(backup);
      progress(all - sqlite3_backup_remaining(backup), all);
    }
  } while (rc == SQLITE_OK);
  if (backup != nullptr) sqlite3_backup_finish(backup);
  // The copied header says WAL; one file without a log is easier to keep.
  if (rc == SQLITE_DONE) {
    rc = sqlite3_exec(copy, "PRAGMA journal_mode = DELETE", nullptr, nullptr, nullptr);
  }
  Status status =
      rc == SQLITE_OK ? Status::Ok() : Told(FailureOf(copy, target.string(), /*opening=*/true));
  sqlite3_close_v2(copy);
  Rollback();
  return begun.ok() ? status : begun;
}

Result<int64_t> SqliteDb::Pragma(const char* sql) {
  Query q(*this, sql);
  const int64_t value = q.Next() ? q.Int(0) : 0;
  ENAMEL_RETURN_IF_ERROR(q.status());
  return value;
}

Result<int> SqliteDb::SchemaVersion() {
  ENAMEL_ASSIGN_OR_RETURN(const int64_t version, Pragma("PRAGMA user_version"));
  // 0 while nothing was migrated: a file that SQLite has just made has no mark yet.
  ENAMEL_ASSIGN_OR_RETURN(const int64_t application, Pragma("PRAGMA application_id"));
  if (version != 0 && application != options_.application_id) {
    return Status(Code::kVersion,
                  path_ +
                      " is a database of another program, or of a version of this one that it does "
                      "not read; name another folder; nothing in this one was changed");
  }
  return static_cast<int>(version);
}

Status SqliteDb::Migrate(const std::vector<Migration>& migrations) {
  Transaction transaction(*this);
  // BEGIN IMMEDIATE, so a second process waits here until the first is done.
  ENAMEL_RETURN_IF_ERROR(transaction.begun());
  // Inside the transaction: another process may have migrated in between.
  ENAMEL_ASSIGN_OR_RETURN(const int version, SchemaVersion());
  for (const Migration& next : migrations) {
    if (next.version <= version) continue;
    if (Status done = Exec(next.sql.c_str()); !done.ok()) {
      return Status(done.code(), "migration " + next.name + ": " + done.message());
    }
  }
  if (!migrations.empty() && version < migrations.back().version) {
    const std::string marks =
        "PRAGMA application_id = " + std::to_string(options_.application_id) +
        "; PRAGMA user_version = " + std::to_string(migrations.back().version);
    ENAMEL_RETURN_IF_ERROR(Exec(marks.c_str()));
  }
  return transaction.Commit();
}

std::string SqliteDb::JsonMember(const std::string& column, const std::string& member) const {
  return "json_extract(" + column + ", '$." + member + "')";
}

// FAST overwrites what costs no write of its own.
Status SqliteDb::OverwriteDeleted(bool on) {
  return Exec(on ? "PRAGMA secure_delete = ON" : "PRAGMA secure_delete = FAST");
}

Status SqliteDb::Told(const SqliteFailure& failure) const {
  if (options_.explain) return options_.explain(failure);
  return Status(CodeOf(failure.kind), failure.path + ": " + failure.words);
}

Status SqliteDb::Fail() {
  failure_ = FailureOf(handle_, path_, opening_);
  damaged_ = damaged_ || failure_.kind == SqliteFailure::Kind::kDamaged;
  return Told(failure_);
}

// There are as many queries of lists as combinations of filters: without a bound, their statements
// would fill the memory.
void SqliteDb::DropOldest() {
  auto oldest = statements_.end();
  for (auto at = statements_.begin(); at != statements_.end(); ++at) {
    if (at->second->in_use()) continue;
    if (oldest == statements_.end() || at->second->last_use() < oldest->second->last_use())
      oldest = at;
  }
  if (oldest != statements_.end()) statements_.erase(oldest);
}

Statement* SqliteDb::Take(const char* sql, Status& status) {
  failure_ = {};
  auto at = statements_.find(sql);
  if (at == statements_.end()) {
    if (statements_.size() >= kMaxStatements) DropOldest();
    sqlite3_stmt* fresh = nullptr;
    // PERSISTENT: memory from the heap and not from the pool for what is soon given back.
    if (sqlite3_prepare_v3(handle_, sql, -1, SQLITE_PREPARE_PERSISTENT, &fresh, nullptr) !=
        SQLITE_OK) {
      status = Fail();
      return nullptr;
    }
    at = statements_.emplace(sql, std::make_unique<SqliteStatement>(*this, fresh)).first;
  }
  SqliteStatement& kept = *at->second;
  // A second use would rewind the first one's rows.
  ENAMEL_CHECK(!kept.busy());
  kept.Use(++uses_);
  return &kept;
}

}  // namespace enamel::sql
