#include "station/spool/spool_file.h"

#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "station/spool/spool.h"
#include "station/spool/spool_migrations.h"
#include "station/spool/statement.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

constexpr int kBusy_ms = 10'000, kWalRetry_ms = 10;

int64_t LatestVersion() { return static_cast<int64_t>(SpoolMigrations().size()); }
std::string SetVersion() { return "PRAGMA user_version = " + std::to_string(LatestVersion()); }

}  // namespace

std::string WhatToDoAbout(int code) {
  switch (code & 0xff) {
    case SQLITE_FULL:
      return "the disk is full: free space there";
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
      return "make the folder writable for this user, or choose another with --data";
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return "the file is damaged: 'enamel-station spool verify' says which recordings are hit, "
             "'enamel-station spool salvage --out FOLDER' saves what can be read of it";
    case SQLITE_BUSY:
      return "another enamel-station is using it: wait until that one has ended";
    default:
      return "see the system's log for this disk";
  }
}

SpoolFile::~SpoolFile() {
  sqlite3_close(handle_);
  std::error_code error;
  if (!copy_.empty()) fs::remove_all(copy_, error);
}

Status SpoolFile::Fail(const char* doing) const {
  int code = sqlite3_extended_errcode(handle_);
  bool damaged = (code & 0xff) == SQLITE_CORRUPT || (code & 0xff) == SQLITE_NOTADB;
  return Status(Code::kStorage,
                "spool " + path_.string() + ": " + doing + " failed (" + sqlite3_errmsg(handle_) +
                    "); " + WhatToDoAbout(code),
                damaged ? kDamagedSpool : "");
}

Status SpoolFile::Exec(const char* sql, const char* doing) {
  return sqlite3_exec(handle_, sql, nullptr, nullptr, nullptr) == SQLITE_OK ? Status::Ok()
                                                                            : Fail(doing);
}

// Two processes that switch a new file to WAL at once: SQLite tells one that it is locked without
// waiting the busy timeout.
Status SpoolFile::UseWal() {
  for (int waited_ms = 0;; waited_ms += kWalRetry_ms) {
    Status done = Exec("PRAGMA journal_mode = WAL", "opening");
    bool busy = !done.ok() && sqlite3_errcode(handle_) == SQLITE_BUSY;
    if (!busy || waited_ms >= kBusy_ms) return done;
    sqlite3_sleep(kWalRetry_ms);
  }
}

Result<int64_t> SpoolFile::Version() {
  Statement s(handle_, "PRAGMA user_version");
  if (s.Step() != SQLITE_ROW) return Fail("reading its version");
  return s.IntAt(0);
}

// Where the file is to be: what must not be taken for a new spool. Empty, or gone with its log left
// behind: SQLite would begin anew and throw the log away.
Status SpoolFile::CheckNotLost() const {
  std::error_code error;
  const bool there = fs::exists(path_, error);
  const fs::path log = path_.string() + "-wal";
  const bool log_holds = fs::exists(log, error) && fs::file_size(log, error) > 0;
  if (there ? fs::file_size(path_, error) > 0 : !log_holds) return Status::Ok();
  return Status(Code::kStorage,
                "spool " + path_.string() + (there ? " is empty (0 bytes)" : " is gone") +
                    (log_holds ? ", its log " + log.string() + " is there" : "") +
                    ": recordings were kept in it. Put a copy of it back, or move what is left of "
                    "it away to begin with an empty spool",
                kLostSpool);
}

// The whole file at once, so that an empty one is never a new one. Nothing when another process was
// first.
Status SpoolFile::Create() {
  const fs::path made = path_.string() + ".new-" + std::to_string(::getpid());
  {
    SpoolFile fresh(made);
    if (sqlite3_open_v2(made.c_str(), &fresh.handle_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE,
                        nullptr) != SQLITE_OK) {
      return fresh.Fail("creating");
    }
    std::error_code error;
    fs::permissions(made, fs::perms::owner_read | fs::perms::owner_write, error);
    Status done = fresh.UseWal();
    if (done.ok()) done = fresh.BringUpToDate();
    if (!done.ok()) {
      sqlite3_close(std::exchange(fresh.handle_, nullptr));
      for (const char* end : {"", "-wal", "-shm"}) fs::remove(made.string() + end, error);
      return done;
    }
  }
  // Some file systems have no links.
  bool linked = ::link(made.c_str(), path_.c_str()) == 0 || errno == EEXIST;
  std::error_code error;
  if (linked)
    fs::remove(made, error);
  else
    fs::rename(made, path_, error);
  return !error
             ? Status::Ok()
             : Status(Code::kStorage, "cannot create " + path_.string() + " (" + error.message() +
                                          "): " + WhatToDoAbout(SQLITE_CANTOPEN));
}

Status SpoolFile::CheckVersion(int64_t version) const {
  if (version <= LatestVersion()) return Status::Ok();
  return Status(Code::kVersion, "spool " + path_.string() + " is of version " +
                                    std::to_string(version) + ", this program knows " +
                                    std::to_string(LatestVersion()) +
                                    ": use the newer enamel-station that made it");
}

Result<std::unique_ptr<SpoolFile>> SpoolFile::Open(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Status(Code::kStorage, "cannot create the folder " + folder.string() + " (" +
                                      error.message() + "): choose another with --data");
  }
  std::unique_ptr<SpoolFile> out(new SpoolFile(folder / kSpoolFile));
  ENAMEL_RETURN_IF_ERROR(out->CheckNotLost());
  if (!fs::exists(out->path_, error)) ENAMEL_RETURN_IF_ERROR(out->Create());
  if (sqlite3_open_v2(out->path_.c_str(), &out->handle_,
                      SQLITE_OPEN_READWRITE | SQLITE_OPEN_FULLMUTEX, nullptr) != SQLITE_OK) {
    return out->Fail("opening");
  }
  sqlite3_busy_timeout(out->handle_, kBusy_ms);
  // Recordings identify people: nobody but the owner reads them.
  fs::permissions(out->path_, fs::perms::owner_read | fs::perms::owner_write, error);
  ENAMEL_RETURN_IF_ERROR(out->UseWal());
  ENAMEL_RETURN_IF_ERROR(
      out->Exec("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON", "opening"));
  ENAMEL_ASSIGN_OR_RETURN(auto version, out->Version());
  ENAMEL_RETURN_IF_ERROR(out->CheckVersion(version));
  if (version < LatestVersion()) ENAMEL_RETURN_IF_ERROR(out->BringUpToDate());
  if (sqlite3_db_readonly(out->handle_, "main") == 1) {
    return Status(Code::kStorage, "spool " + out->path_.string() +
                                      " is not writable: " + WhatToDoAbout(SQLITE_READONLY));
  }
  return out;
}

// Also a file that is cut short, or whose schema has errors, is opened for what can be read of it.
Status SpoolFile::OpenForReading(const std::string& uri, int flags) {
  sqlite3_close(std::exchange(handle_, nullptr));
  if (sqlite3_open_v2(uri.c_str(), &handle_, flags | SQLITE_OPEN_URI | SQLITE_OPEN_FULLMUTEX,
                      nullptr) != SQLITE_OK) {
    return Fail("opening");
  }
  sqlite3_busy_timeout(handle_, kBusy_ms);
  return Exec("PRAGMA writable_schema = ON; SELECT count(*) FROM sqlite_schema", "opening");
}

// What cannot be read where it lies (its log needs a writable folder, or it is of an older version)
// is read in a copy.
Status SpoolFile::OpenCopy() {
  std::string name = (fs::temp_directory_path() / "enamel_spool_XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    return Status(Code::kStorage, "cannot make a folder in " + fs::temp_directory_path().string() +
                                      " to read " + path_.string() + " in a copy (" +
                                      std::strerror(errno) + ")");
  }
  copy_ = name;
  std::error_code error;
  fs::copy_file(path_, copy_ / kSpoolFile, error);
  const std::string log = path_.string() + "-wal";
  if (!error && fs::exists(log)) {
    fs::copy_file(log, (copy_ / kSpoolFile).string() + "-wal", error);
  }
  if (error) {
    return Status(Code::kStorage, "cannot copy " + path_.string() + " to " + copy_.string() + " (" +
                                      error.message() + ")");
  }
  return OpenForReading((copy_ / kSpoolFile).string(), SQLITE_OPEN_READWRITE);
}

Result<std::unique_ptr<SpoolFile>> SpoolFile::OpenToRead(const fs::path& folder) {
  std::unique_ptr<SpoolFile> out(new SpoolFile(folder / kSpoolFile));
  ENAMEL_RETURN_IF_ERROR(out->CheckNotLost());
  std::error_code error;
  if (!fs::exists(out->path_, error)) {
    return Status(Code::kNotFound, "there is no spool in " + folder.string() +
                                       ": nothing was recorded there, or another folder is meant "
                                       "(--data)");
  }
  const std::string path = out->path_.string();
  Status opened = out->OpenForReading(path, SQLITE_OPEN_READONLY);
  const int code = out->handle_ == nullptr ? SQLITE_CANTOPEN : sqlite3_errcode(out->handle_);
  if (!opened.ok() && (code == SQLITE_CANTOPEN || code == SQLITE_READONLY))
    opened = out->OpenCopy();
  ENAMEL_RETURN_IF_ERROR(opened);
  ENAMEL_ASSIGN_OR_RETURN(auto version, out->Version());
  ENAMEL_RETURN_IF_ERROR(out->CheckVersion(version));
  if (version < LatestVersion()) {
    if (out->copy_.empty()) ENAMEL_RETURN_IF_ERROR(out->OpenCopy());
    ENAMEL_RETURN_IF_ERROR(out->BringUpToDate());
  }
  return out;
}

// All that are missing in one transaction: a crash leaves the spool as it was. The version is read
// inside it, as another process may have brought it up to date meanwhile.
Status SpoolFile::BringUpToDate() {
  SpoolTransaction transaction(handle_);
  if (!transaction.open()) return Fail("beginning to create its tables");
  ENAMEL_ASSIGN_OR_RETURN(const int64_t version, Version());
  const std::string doing = version == 0
                                ? "creating its tables"
                                : "bringing it to version " + std::to_string(LatestVersion());
  for (int64_t next = version; next < LatestVersion(); ++next) {
    const SpoolMigration& migration = SpoolMigrations()[static_cast<size_t>(next)];
    ENAMEL_RETURN_IF_ERROR(Exec(migration.sql.c_str(), doing.c_str()));
  }
  ENAMEL_RETURN_IF_ERROR(Exec(SetVersion().c_str(), doing.c_str()));
  return transaction.Commit() ? Status::Ok() : Fail(doing.c_str());
}

Status SpoolFile::TestWrite() {
  // Writes its first page although the value is the same.
  return Exec(SetVersion().c_str(), "a test write");
}

}  // namespace enamel::station
