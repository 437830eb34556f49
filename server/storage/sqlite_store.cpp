#include "server/storage/sqlite_store.h"

#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "common/base/file.h"
#include "server/storage/sqlite_impl.h"

namespace enamel::server {
namespace sqlite {

Result<std::unique_ptr<SqliteDb>> Readers::Take() {
  {
    std::unique_lock lock(mutex_);
    // Without a bound of its own: who has one keeps it for one read, and who must not wait so long
    // asks on a thread that others do not need (StorePool; an HTTP request ends after 60 s).
    returned_.wait(lock, [&] { return !idle_.empty() || open_ < most_; });
    if (!idle_.empty()) {
      auto db = std::move(idle_.back());
      idle_.pop_back();
      return db;
    }
    ++open_;
  }
  auto db = OpenDatabase(path_, DbMode::kReadOnly, vfs_);
  if (db.ok()) return db;
  {
    std::lock_guard lock(mutex_);
    --open_;
    returned_.notify_one();
  }
  spdlog::warn("database: {}", db.status().message());
  return Status(db.status().code(), "the database cannot be read; the log says why");
}

void Readers::Return(std::unique_ptr<SqliteDb> db) {
  std::lock_guard lock(mutex_);
  idle_.push_back(std::move(db));
  returned_.notify_one();
}

namespace {

Disk& DiskOf(const SqliteOptions& options) {
  return options.disk != nullptr ? *options.disk : SystemDisk();
}

bool IsThere(const std::filesystem::path& file) {
  std::error_code error;
  return std::filesystem::exists(file, error);
}

std::unique_ptr<SqliteDb> Patient(std::unique_ptr<SqliteDb> db, std::chrono::milliseconds busy_wait,
                                  std::function<bool()> worth_it) {
  db->SetBusyWait(busy_wait, std::move(worth_it));
  return db;
}

}  // namespace

SqliteStore::SqliteStore(const SqliteOptions& options, std::unique_ptr<SqliteDb> writer,
                         FolderLock lock)
    : folder_(options.folder),
      lock_(std::move(lock)),
      writer_(Patient(std::move(writer), options.busy_wait, [this] { return OthersErase(); }),
              options.change_twice),
      readers_(options.folder / "enamel.db", options.readers, options.vfs),
      blobs_(options.folder / "blobs", DiskOf(options), options.fail_next),
      keyring_(options.folder / "keyring", DiskOf(options)),
      space_(options.folder, DiskOf(options), options.min_free_bytes, options.free_space_check),
      // Who holds the folder's lock is the only worker there is.
      earlier_leases_(options.hold_lock) {
  if (options.hold_lock) sealed_rows_.emplace(writer_);
}

Result<Sha256> SqliteStore::PutBlob(ByteView data) {
  ENAMEL_RETURN_IF_ERROR(MayRecord());
  return blobs_.Put(data);
}

Result<Sha256> SqliteStore::PutAttemptBlob(const Uuid& attempt, ByteView data) {
  ENAMEL_RETURN_IF_ERROR(MayRecord());
  ENAMEL_ASSIGN_OR_RETURN(auto key, KeyOf(attempt));
  return blobs_.Put(SealPersonal(key.person, key.key, attempt, data));
}

Result<Bytes> SqliteStore::GetBlob(const Sha256& hash) {
  auto bytes = blobs_.Get(hash);
  if (!bytes.ok()) return bytes;
  return OpenPersonal(keyring_, std::move(bytes).value());
}

Result<SqliteStore::PersonKey> SqliteStore::KeyOf(const Uuid& attempt) {
  std::string name(AsText(attempt.view()));
  Uuid person;
  {
    std::lock_guard lock(people_mutex_);
    auto known = person_of_.find(name);
    if (known != person_of_.end()) person = known->second;
  }
  if (person.IsZero()) {
    ENAMEL_ASSIGN_OR_RETURN(auto row, AttemptById(attempt));
    person = row.person;
    std::lock_guard lock(people_mutex_);
    if (person_of_.size() >= kMaxRemembered) person_of_.clear();
    person_of_[name] = person;
  }
  ENAMEL_ASSIGN_OR_RETURN(auto key, keyring_.FindOrMake(person));
  return PersonKey{person, key};
}

Status SqliteStore::MayRecord() {
  if (damaged_ || writer_.damaged()) {
    return Status(Code::kUnavailable,
                  "the server's database is damaged: stop the server, see what verify says, and "
                  "restore a backup; recordings wait at the stations");
  }
  return space_.Check();
}

StoreHealth SqliteStore::Health() {
  StoreHealth out;
  out.free_bytes = space_.FreeBytes();
  out.min_free_bytes = space_.min_free_bytes();
  std::error_code error;
  auto size = [&](const char* name) -> uint64_t {
    uintmax_t bytes = std::filesystem::file_size(folder_ / name, error);
    return error ? 0 : bytes;
  };
  out.database_bytes = size("enamel.db");
  out.log_bytes = size("enamel.db-wal");
  Writer::Counters counters = writer_.counters();
  out.commits = counters.commits;
  out.writes = counters.works;
  out.failed_commits = counters.failed_commits;
  out.commit_s = counters.commit_s;
  out.chunks = chunks_;
  out.chunk_bytes = chunk_bytes_;
  out.sealed = sealed_;
  if (Status able = MayRecord(); !able.ok()) out.problem = able.message();
  if (out.problem.empty() && !writer_.last_failure().ok()) {
    out.problem =
        "the last change could not be written to the database; the server's log says why. "
        "Recordings wait at the stations, the next write that succeeds ends this";
  }
  out.takes_recordings = out.problem.empty();
  if (rewriting_ || writer_.waits()) {
    out.waiting =
        "a person was erased and the database is being written anew; changes and recordings wait "
        "until that is done";
  }
  return out;
}

Status SqliteStore::TryWrite() {
  if (writer_.last_failure().ok() || writer_.damaged()) return Status::Ok();
  return Write([](Db& db) -> Status {
    Query q(db,
            "INSERT INTO write_probe (tenant, at_ms) VALUES (?1, ?2) ON CONFLICT (tenant) DO "
            "UPDATE SET at_ms = ?2");
    return q.Bind(NowMs()).Run();
  });
}

Status SqliteStore::MarkForRewrite() { return WriteFileDurably(folder_ / kRewriteMark, {}); }

Result<SqliteStore::Upkeep> SqliteStore::TakeUpkeep() {
  ENAMEL_ASSIGN_OR_RETURN(auto lock, TakeUpkeepLock(folder_, FolderLock::Mode::kExclusive));
  return Upkeep(std::move(lock), upkeep_);
}

bool SqliteStore::OthersErase() const {
  return upkeep_ == 0 && IsThere(folder_ / kRewriteMark) && IsUpkeepAlone(folder_);
}

// In the log, and in SQLite's temporary file, which may be on the same disk, with a fiftieth for
// the log's frames.
Status SqliteStore::RoomToRewrite(SqliteDb& db) {
  ENAMEL_ASSIGN_OR_RETURN(const uint64_t bytes, db.Bytes());
  return space_.RoomFor(2 * bytes + bytes / 50);
}

Status SqliteStore::RewriteIfMarked() {
  if (!IsThere(folder_ / kRewriteMark)) return Status::Ok();
  spdlog::info("the database is being written anew after an erasure; changes wait until it is");
  const auto begin = std::chrono::steady_clock::now();
  rewriting_ = true;
  Status status = writer_.RunAlone([&](SqliteDb& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(RoomToRewrite(db));
    Status rewritten = db.Rewrite();
    Status emptied = db.EmptyLog();
    return rewritten.ok() ? emptied : rewritten;
  });
  rewriting_ = false;
  std::error_code error;
  if (status.ok() && !std::filesystem::remove(folder_ / kRewriteMark, error) && error) {
    status = Status(Code::kStorage,
                    "cannot remove " + (folder_ / kRewriteMark).string() + ": " + error.message());
  }
  if (status.ok()) {
    std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    spdlog::info("the database is written anew, which took {:.1f} s", took.count());
  } else {
    spdlog::warn(
        "the database could not be written anew after an erasure: {}. Copies of what was erased "
        "may stay in unused parts of it until the server does that, tried again every hour and "
        "after its next start",
        status.message());
  }
  return status;
}

Status SqliteStore::FinishErasures() {
  if (!IsThere(folder_ / kRewriteMark)) return Status::Ok();
  auto alone = TakeUpkeep();
  return alone.ok() ? RewriteIfMarked() : alone.status();
}

Result<size_t> SqliteStore::SweepUnnamed(std::chrono::seconds age) {
  ENAMEL_ASSIGN_OR_RETURN(auto listing, blobs_.List());
  // Read after the list: whatever is on it and was named meanwhile is not swept.
  auto named = Read([](Db& db) { return NamedBlobs(db); });
  if (!named.ok()) return named.status();
  size_t removed = 0;
  for (const Sha256& blob : listing.blobs) {
    if (named->contains(blob)) continue;
    ENAMEL_ASSIGN_OR_RETURN(auto gone, blobs_.RemoveIfOlder(blob, age));
    removed += gone ? 1 : 0;
  }
  return removed;
}

Result<size_t> SqliteStore::RemoveUnnamed(const std::set<Sha256>& blobs) {
  auto named = Read([](Db& db) { return NamedBlobs(db); });
  if (!named.ok()) return named.status();
  size_t removed = 0;
  for (const Sha256& blob : blobs) {
    if (named->contains(blob) || !blobs_.Has(blob)) continue;
    ENAMEL_RETURN_IF_ERROR(blobs_.Remove(blob));
    ++removed;
  }
  return removed;
}

Json JsonOf(std::initializer_list<std::pair<const char*, std::string>> members) {
  boost::json::object object;
  for (const auto& [name, value] : members) object[name] = value;
  return boost::json::serialize(object);
}

namespace {

// Ids are in the order of time; the trail's order holds also where the clock has been set back.
Result<Uuid> NextAuditId(Db& db) {
  Uuid fresh = Uuid::New();
  Query q(db, "SELECT id FROM audit WHERE tenant = ?1 ORDER BY id DESC LIMIT 1");
  Uuid newest;
  if (q.Next()) newest = q.Id(0);
  if (!q.status().ok()) return q.status();
  if (newest.bytes < fresh.bytes) return fresh;
  for (size_t i = newest.bytes.size(); i-- > 0;) {
    if (++newest.bytes[i] != 0) break;
  }
  return newest;
}

}  // namespace

Status WriteAudit(Db& db, const Actor& by, const char* action, const std::string& object,
                  const Json& before, const Json& after) {
  ENAMEL_ASSIGN_OR_RETURN(auto id, NextAuditId(db));
  Query q(
      db,
      "INSERT INTO audit (tenant, id, at_ms, actor, via, action, object, before_json, after_json) "
      "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)");
  q.Bind(id).Bind(NowMs()).Bind(by.person).Bind(by.via).Bind(std::string(action));
  return q.Bind(object).Bind(before).Bind(after).Run();
}

Status Explain(Status status, const std::string& conflict) {
  if (status.code() != Code::kConflict) return status;
  return Status(Code::kConflict, conflict);
}

namespace {

// What root writes, the folder's owner could not read.
Status MustNotBeRootForAnother(const std::filesystem::path& folder) {
  struct stat info {};
  if (::geteuid() != 0 || ::stat(folder.c_str(), &info) != 0 || info.st_uid == 0)
    return Status::Ok();
  return Status(Code::kForbidden,
                folder.string() + " belongs to user " + std::to_string(info.st_uid) +
                    ", who could not read what root writes there; run this as that user: runuser "
                    "-u USER -- enamel-server …");
}

// Who reads the folder has everything. A folder of other things is not ours to close: it may be a
// home, or /tmp.
Status KeepOthersOut(const std::filesystem::path& folder) {
  struct stat info {};
  constexpr mode_t kOthers = 077, kOwnerOnly = 0700;
  if (::stat(folder.c_str(), &info) != 0 || (info.st_mode & kOthers) == 0) return Status::Ok();
  char mode[8];
  std::snprintf(mode, sizeof mode, "%04o", static_cast<unsigned>(info.st_mode & 07777));
  std::error_code error;
  const bool ours = std::filesystem::exists(folder / "enamel.db", error) ||
                    std::filesystem::is_empty(folder, error);
  if (ours && ::chmod(folder.c_str(), kOwnerOnly) == 0) {
    spdlog::warn("the data folder {} let others in (mode {}); it is 0700 now", folder.string(),
                 mode);
    return Status::Ok();
  }
  return Status(Code::kForbidden,
                "expected a data folder that lets nobody else in (mode 0700), "
                "found " +
                    folder.string() + " with mode " + mode +
                    (ours ? std::string() : " and with other things in it") +
                    "; name a folder of its own, or: chmod 700 " + folder.string());
}

Status MakeFolder(const std::filesystem::path& folder, Disk& disk, bool restoring) {
  if (Status made = disk.MakeFolder(folder); !made.ok()) {
    return Status(Code::kStorage, "cannot make the data folder " + folder.string() + ": " +
                                      made.message() + "; name a folder this user may write");
  }
  ENAMEL_RETURN_IF_ERROR(MustNotBeRootForAnother(folder));
  if (!restoring && std::filesystem::exists(folder / kRestoreMark)) {
    return Status(Code::kConflict, folder.string() +
                                       " holds a restore that did not finish; empty the folder and "
                                       "restore again");
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    return Status(Code::kStorage, "the data folder " + folder.string() + " is not writable: " +
                                      std::strerror(errno) + "; name a folder this user may write");
  }
  ENAMEL_RETURN_IF_ERROR(KeepOthersOut(folder));
  ENAMEL_RETURN_IF_ERROR(disk.MakeFolder(folder / "blobs"));
  // A process that was killed may have left entries unsynced.
  ENAMEL_RETURN_IF_ERROR(disk.SyncFolder(folder / "blobs"));
  return disk.SyncFolder(folder);
}

}  // namespace
}  // namespace sqlite

int LatestSchemaVersion() { return static_cast<int>(sqlite::Migrations().size()); }

Result<std::unique_ptr<Store>> OpenSqliteStore(const SqliteOptions& options) {
  using namespace sqlite;
  ENAMEL_RETURN_IF_ERROR(MakeFolder(options.folder, DiskOf(options), options.restoring));
  std::optional<FolderLock> lock;
  auto acquire = [&]() -> Status {
    auto held = FolderLock::Take(options.folder / kServerLock, FolderLock::Mode::kExclusive,
                                 "another enamel-server uses " + options.folder.string() +
                                     "; stop it first or name another folder");
    if (!held.ok()) return held.status();
    lock.emplace(std::move(held).value());
    return Status::Ok();
  };
  if (options.hold_lock) ENAMEL_RETURN_IF_ERROR(acquire());
  auto db =
      OpenDatabase(options.folder / "enamel.db", DbMode::kCreate, options.vfs, options.fail_next);
  if (!db.ok()) return db.status();
  (*db)->SetBusyWait(options.busy_wait);
  ENAMEL_ASSIGN_OR_RETURN(auto version, SchemaVersion(**db));
  if (version < LatestSchemaVersion()) {
    if (!lock) ENAMEL_RETURN_IF_ERROR(acquire());
    ENAMEL_RETURN_IF_ERROR((*db)->Migrate(Migrations()));
  }
  if (!options.hold_lock) lock.reset();
  FolderLock kept = lock ? std::move(*lock) : FolderLock();
  auto store = std::make_unique<SqliteStore>(options, std::move(db).value(), std::move(kept));
  if (options.hold_lock) ENAMEL_RETURN_IF_ERROR(store->Reconcile());
  return std::unique_ptr<Store>(std::move(store));
}

}  // namespace enamel::server
