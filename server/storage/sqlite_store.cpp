#include "server/storage/sqlite_store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <cerrno>
#include <cstring>

#include "server/storage/migrate.h"
#include "server/storage/sqlite_impl.h"

namespace enamel::server {
namespace sqlite {

Result<std::unique_ptr<Db>> Readers::Take() {
  {
    std::unique_lock lock(mutex_);
    returned_.wait(lock, [&] { return !idle_.empty() || open_ < most_; });
    if (!idle_.empty()) {
      auto db = std::move(idle_.back());
      idle_.pop_back();
      return db;
    }
    ++open_;
  }
  auto db = Db::Open(path_, Db::Mode::kReadOnly);
  if (!db.ok()) {
    std::lock_guard lock(mutex_);
    --open_;
    returned_.notify_one();
  }
  return db;
}

void Readers::Return(std::unique_ptr<Db> db) {
  std::lock_guard lock(mutex_);
  idle_.push_back(std::move(db));
  returned_.notify_one();
}

FolderLock::~FolderLock() {
  if (fd_ >= 0) ::close(fd_);
}

SqliteStore::SqliteStore(const SqliteOptions& options, std::unique_ptr<Db> writer, FolderLock lock)
    : lock_(std::move(lock)),
      writer_(std::move(writer)),
      readers_(options.folder / "enamel.db", options.readers),
      blobs_(options.folder / "blobs", options.fail_next) {}

Json JsonOf(std::initializer_list<std::pair<const char*, std::string>> members) {
  boost::json::object object;
  for (const auto& [name, value] : members) object[name] = value;
  return boost::json::serialize(object);
}

Status WriteAudit(Db& db, const Actor& by, const char* action, const std::string& object,
                  const Json& before, const Json& after) {
  Query q(
      db,
      "INSERT INTO audit (tenant, id, at_ms, actor, via, action, object, before_json, after_json) "
      "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)");
  q.Bind(Uuid::New()).Bind(NowMs()).Bind(by.person).Bind(by.via).Bind(std::string(action));
  return q.Bind(object).Bind(before).Bind(after).Run();
}

Status Explain(Status status, const std::string& conflict) {
  if (status.code() != Code::kConflict) return status;
  return Status(Code::kConflict, conflict);
}

namespace {

// Errors: kUnavailable when another process holds it.
Result<FolderLock> LockFolder(const std::filesystem::path& folder) {
  std::filesystem::path path = folder / "LOCK";
  int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0) {
    return Status(Code::kStorage, "cannot open " + path.string() + ": " + std::strerror(errno) +
                                      "; name a folder this user may write");
  }
  FolderLock lock(fd);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return Status(Code::kUnavailable, "another enamel-server uses " + folder.string() +
                                          "; stop it first or name another folder");
  }
  return lock;
}

Status MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  bool made = std::filesystem::create_directories(folder, error);
  if (error) {
    return Status(Code::kStorage, "cannot make the data folder " + folder.string() + ": " +
                                      error.message() + "; name a folder this user may write");
  }
  if (made) std::filesystem::permissions(folder, std::filesystem::perms::owner_all, error);
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    return Status(Code::kStorage, "the data folder " + folder.string() + " is not writable: " +
                                      std::strerror(errno) + "; name a folder this user may write");
  }
  std::filesystem::create_directories(folder / "blobs", error);
  if (error) return Status(Code::kStorage, "cannot make " + (folder / "blobs").string());
  return Status::Ok();
}

}  // namespace
}  // namespace sqlite

int LatestSchemaVersion() { return static_cast<int>(sqlite::Migrations().size()); }

Result<std::unique_ptr<Store>> OpenSqliteStore(const SqliteOptions& options) {
  using namespace sqlite;
  ENAMEL_RETURN_IF_ERROR(MakeFolder(options.folder));
  std::optional<FolderLock> lock;
  auto acquire = [&]() -> Status {
    auto held = LockFolder(options.folder);
    if (!held.ok()) return held.status();
    lock.emplace(std::move(held).value());
    return Status::Ok();
  };
  if (options.hold_lock) ENAMEL_RETURN_IF_ERROR(acquire());
  auto db = Db::Open(options.folder / "enamel.db", Db::Mode::kReadWrite, options.fail_next);
  if (!db.ok()) return db.status();
  auto version = SchemaVersion(**db);
  if (!version.ok()) return version.status();
  if (*version < LatestSchemaVersion()) {
    if (!lock) ENAMEL_RETURN_IF_ERROR(acquire());
    ENAMEL_RETURN_IF_ERROR(Migrate(**db));
  }
  if (!options.hold_lock) lock.reset();
  // Who holds the folder's lock is the only worker there is: leases of a killed one are over.
  if (lock) ENAMEL_RETURN_IF_ERROR(EndLeases(**db));
  FolderLock kept = lock ? std::move(*lock) : FolderLock();
  return std::unique_ptr<Store>(new SqliteStore(options, std::move(db).value(), std::move(kept)));
}

}  // namespace enamel::server
