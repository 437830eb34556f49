#include "server/storage/db.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <thread>

namespace enamel::server::sqlite {
namespace {

constexpr int64_t kTenant = 1;
// Between two looks whether another process still keeps the database.
constexpr std::chrono::milliseconds kFirstLook{1}, kNextLook{20};
// Steps of SQLite's machine between two questions whether to go on.
constexpr int kStepsAtOnce = 10'000;

Status ErrorOf(sqlite3* handle, const std::string& path) {
  int code = sqlite3_extended_errcode(handle);
  std::string what = path + ": " + sqlite3_errmsg(handle);
  switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return Status(Code::kUnavailable, what + "; another process is writing, try again");
    case SQLITE_INTERRUPT:
      return Status(Code::kUnavailable, what + "; the program is ending");
    case SQLITE_FULL:
      return Status(Code::kStorage, what + "; free some disk space");
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return Status(Code::kStorage,
                    what + "; make the folder and its files writable for this user");
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return Status(Code::kStorage, what + "; the database is damaged, restore a backup");
    case SQLITE_CONSTRAINT:
      return Status(Code::kConflict, what);
    default:
      return Status(Code::kStorage, what);
  }
}

// The same for whoever asked: no path, no words of SQLite's.
Status WithoutDetail(int code) {
  switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return Status(Code::kUnavailable,
                    "the database is busy with another process's write; try again");
    case SQLITE_INTERRUPT:
      return Status(Code::kUnavailable, "the server is stopping; try again when it runs again");
    case SQLITE_FULL:
      return Status(Code::kStorage, "the database's disk is full; free some disk space");
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return Status(Code::kStorage,
                    "the database may not be written; make the data folder and its files writable "
                    "for the server's user");
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return Status(Code::kStorage, "the database is damaged, restore a backup");
    case SQLITE_CONSTRAINT:
      return Status(Code::kConflict,
                    "this does not go with what is stored: something is there already, or what it "
                    "names is not there; read it again, then try again");
    default:
      return Status(Code::kStorage, "the database failed; the log says why");
  }
}

// A name that is taken is everyday life.
bool IsRoutine(int code) {
  return code == SQLITE_CONSTRAINT_UNIQUE || code == SQLITE_CONSTRAINT_PRIMARYKEY;
}

}  // namespace

Result<std::unique_ptr<Db>> Db::Open(const std::filesystem::path& path, Mode mode,
                                     const std::string& vfs, std::function<bool()> fail_next) {
  sqlite3* handle = nullptr;
  int flags =
      mode == Mode::kReadOnly ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  int rc = sqlite3_open_v2(path.c_str(), &handle, flags | SQLITE_OPEN_NOMUTEX,
                           vfs.empty() ? nullptr : vfs.c_str());
  if (rc != SQLITE_OK) {
    Status status = ErrorOf(handle, path.string());
    sqlite3_close_v2(handle);
    return status;
  }
  std::unique_ptr<Db> db(new Db(handle, path.string(), {}));
  sqlite3_extended_result_codes(handle, 1);
  sqlite3_busy_handler(
      handle, [](void* db, int count) { return static_cast<Db*>(db)->WaitOn(count == 0) ? 1 : 0; },
      db.get());
  const char* setup =
      mode == Mode::kReadOnly
          ? "PRAGMA query_only = 1"
          : "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA foreign_keys = 1; "
            // Under load the same pages are written again and again: 32 MiB of log between
            // checkpoints instead of 4 write each to the database an eighth as often.
            "PRAGMA wal_autocheckpoint = 8192; "
            // Some builds of SQLite overwrite whatever is deleted, which writes a sealed
            // recording's rows to the disk once more. What must not be readable is overwritten by
            // ErasePerson.
            "PRAGMA secure_delete = FAST";
  ENAMEL_RETURN_IF_ERROR(db->Exec(setup));
  db->fail_next_ = std::move(fail_next);
  return db;
}

Db::~Db() {
  for (auto& [sql, kept] : statements_) sqlite3_finalize(kept.statement);
  sqlite3_close_v2(handle_);
}

Status Db::Exec(const char* sql) {
  if (InjectedFailure()) return Status(Code::kStorage, "injected failure");
  int rc = sqlite3_exec(handle_, sql, nullptr, nullptr, nullptr);
  waits_ = false;
  return rc == SQLITE_OK ? Status::Ok() : Error();
}

void Db::SetBusyWait(std::chrono::milliseconds wait, std::function<bool()> worth_it) {
  busy_wait_ = wait;
  worth_it_ = std::move(worth_it);
}

bool Db::WaitOn(bool first) {
  const auto now = std::chrono::steady_clock::now();
  if (first) busy_since_ = counted_since_ = now;
  waits_ = worth_it_ && now - busy_since_ < kMostWait && worth_it_();
  if (waits_) counted_since_ = now;
  if (stopped_ || now - counted_since_ >= busy_wait_) return false;
  std::this_thread::sleep_for(first ? kFirstLook : kNextLook);
  return true;
}

void Db::StopWaiting() {
  stopped_ = true;
  if (interruptible_) sqlite3_interrupt(handle_);
}

// The question between steps makes sure of an end that was asked for just before the beginning.
Status Db::Rewrite() {
  sqlite3_progress_handler(
      handle_, kStepsAtOnce, [](void* db) { return static_cast<Db*>(db)->stopped_ ? 1 : 0; }, this);
  interruptible_ = true;
  Status status = Exec("VACUUM");
  interruptible_ = false;
  sqlite3_progress_handler(handle_, 0, nullptr, nullptr);
  return status;
}

// SQLite waits for readers, and not for another connection that empties the log.
Status Db::EmptyLog() {
  const auto until = std::chrono::steady_clock::now() + busy_wait_;
  Status status;
  bool busy = true;
  interruptible_ = true;
  while (status.ok() && busy && !stopped_) {
    {
      Query q(*this, "PRAGMA wal_checkpoint(TRUNCATE)", Query::kNoTenant);
      busy = q.Next() && q.Int(0) != 0;
      status = q.status();
    }
    if (std::chrono::steady_clock::now() >= until) break;
    if (busy) std::this_thread::sleep_for(kNextLook);
  }
  interruptible_ = false;
  if (!status.ok() || !busy) return status;
  return Status(Code::kUnavailable,
                stopped_ ? "the server is stopping before the database's log is empty"
                         : "another program reads what is in the database's log, or is about to "
                           "empty it");
}

void Db::Rollback() {
  if (sqlite3_get_autocommit(handle_) == 0)
    sqlite3_exec(handle_, "ROLLBACK", nullptr, nullptr, nullptr);
}

Status Db::CopyTo(const std::filesystem::path& target, const CopyProgress& progress) {
  constexpr int kPagesAtOnce = 4096;
  sqlite3* copy = nullptr;
  int rc =
      sqlite3_open_v2(target.c_str(), &copy, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
  sqlite3_backup* backup = nullptr;
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
  Status status = rc == SQLITE_OK ? Status::Ok() : ErrorOf(copy, target.string());
  sqlite3_close_v2(copy);
  Rollback();
  return begun.ok() ? status : begun;
}

Status Db::Error() const {
  const int code = sqlite3_errcode(handle_) & 0xff;
  damaged_ = damaged_ || code == SQLITE_CORRUPT || code == SQLITE_NOTADB;
  const int detail = sqlite3_extended_errcode(handle_);
  if (!IsRoutine(detail)) {
    spdlog::warn("database: {} (SQLite {})", ErrorOf(handle_, path_).message(), detail);
  }
  return WithoutDetail(detail);
}

void Db::DropOldest() {
  auto oldest = statements_.end();
  for (auto at = statements_.begin(); at != statements_.end(); ++at) {
    if (at->second.users > 0) continue;
    if (oldest == statements_.end() || at->second.last_use < oldest->second.last_use) oldest = at;
  }
  if (oldest == statements_.end()) return;
  sqlite3_finalize(oldest->second.statement);
  statements_.erase(oldest);
}

Db::Kept* Db::Take(const char* sql, Status& status) {
  auto at = statements_.find(sql);
  if (at == statements_.end()) {
    if (statements_.size() >= kMaxStatements) DropOldest();
    Kept fresh;
    if (sqlite3_prepare_v3(handle_, sql, -1, SQLITE_PREPARE_PERSISTENT, &fresh.statement,
                           nullptr) != SQLITE_OK) {
      status = Error();
      return nullptr;
    }
    at = statements_.emplace(sql, fresh).first;
  }
  Kept& kept = at->second;
  ENAMEL_CHECK(!sqlite3_stmt_busy(kept.statement));
  ++kept.users;
  kept.last_use = ++uses_;
  return &kept;
}

Query::Query(Db& db, const char* sql) : Query(db, sql, kNoTenant) { Bind(kTenant); }

Query::Query(Db& db, const char* sql, NoTenant) : db_(db) {
  kept_ = db.Take(sql, status_);
  if (kept_ != nullptr) statement_ = kept_->statement;
}

Query::~Query() {
  if (statement_ == nullptr) return;
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
  --kept_->users;
}

void Query::Check(int rc) {
  if (rc != SQLITE_OK && status_.ok()) status_ = db_.Error();
}

Query& Query::Bind(int64_t value) {
  if (statement_) Check(sqlite3_bind_int64(statement_, next_parameter_++, value));
  return *this;
}

Query& Query::Bind(double value) {
  if (statement_) Check(sqlite3_bind_double(statement_, next_parameter_++, value));
  return *this;
}

Query& Query::Bind(const std::string& value) {
  if (!statement_) return *this;
  Check(sqlite3_bind_text64(statement_, next_parameter_++, value.data(), value.size(),
                            SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

Query& Query::BindNull() {
  if (statement_) Check(sqlite3_bind_null(statement_, next_parameter_++));
  return *this;
}

Query& Query::Bind(ByteView value) {
  static const uint8_t kNothing = 0;
  if (!statement_) return *this;
  Check(sqlite3_bind_blob64(statement_, next_parameter_++, value.empty() ? &kNothing : value.data(),
                            value.size(), SQLITE_TRANSIENT));
  return *this;
}

bool Query::Next() {
  if (!status_.ok()) return false;
  if (!sqlite3_stmt_readonly(statement_) && db_.InjectedFailure()) {
    status_ = Status(Code::kStorage, "injected failure");
    return false;
  }
  int rc = sqlite3_step(statement_);
  if (rc == SQLITE_ROW) return true;
  if (rc != SQLITE_DONE) status_ = db_.Error();
  return false;
}

Status Query::Run() {
  Next();
  return status_;
}

ByteView Query::View(int column) const {
  const void* data = sqlite3_column_blob(statement_, column);
  int size = sqlite3_column_bytes(statement_, column);
  return {static_cast<const uint8_t*>(data), static_cast<size_t>(size)};
}

std::string Query::Text(int column) const { return std::string(AsText(View(column))); }

Bytes Query::Blob(int column) const {
  ByteView view = View(column);
  return Bytes(view.begin(), view.end());
}

Uuid Query::Id(int column) const {
  ByteView view = View(column);
  return view.size() == 16 ? Uuid::FromBytes(view) : Uuid{};
}

Sha256 Query::Hash(int column) const {
  ByteView view = View(column);
  return view.size() == 32 ? Sha256::FromBytes(view) : Sha256{};
}

int64_t NowMs() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace enamel::server::sqlite
