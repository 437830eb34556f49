#include "server/storage/engine/database.h"

#include <string_view>
#include <utility>

#include "server/storage/engine/database_log.h"

namespace enamel::server {
namespace {

// "Enst": marks the file as ours.
constexpr int32_t kApplicationId = 0x456e7374;

constexpr char kSetup[] =
    // Under load the same pages are written again and again: 32 MiB of log between checkpoints
    // instead of 4 write each to the database an eighth as often.
    "PRAGMA wal_autocheckpoint = 8192; "
    // Some builds of SQLite overwrite whatever is deleted, which writes a sealed recording's rows
    // to the disk once more. What must not be readable is overwritten by ErasePerson.
    "PRAGMA secure_delete = FAST";

using Kind = sql::SqliteFailure::Kind;

// For readers who may see paths: the log, and whoever starts the program.
Status InFull(const sql::SqliteFailure& failure) {
  const std::string what = failure.path + ": " + failure.words;
  switch (failure.kind) {
    case Kind::kBusy:
      return Status(Code::kUnavailable, what + "; another process is writing, try again");
    case Kind::kInterrupted:
      return Status(Code::kUnavailable, what + "; the program is ending");
    case Kind::kFull:
      return Status(Code::kStorage, what + "; free some disk space");
    case Kind::kNotWritable:
      return Status(Code::kStorage,
                    what + "; make the folder and its files writable for this user");
    case Kind::kDamaged:
      return Status(Code::kStorage, what + "; the database is damaged, restore a backup");
    case Kind::kConstraint:
    case Kind::kTaken:
      return Status(Code::kConflict, what);
    case Kind::kData:
      return Status(Code::kInvalidInput, what);
    case Kind::kOwnFault:
      return Status(Code::kInternal, what);
    case Kind::kOther:
      break;
  }
  return Status(Code::kStorage, what);
}

// The same for callers, who may be anybody.
Status WithoutDetail(Kind kind) {
  switch (kind) {
    case Kind::kBusy:
      return Status(Code::kUnavailable,
                    "the database is busy with another process's write; try again");
    case Kind::kInterrupted:
      return Status(Code::kUnavailable, "the server is stopping; try again when it runs again");
    case Kind::kFull:
      return Status(Code::kStorage, "the database's disk is full; free some disk space");
    case Kind::kNotWritable:
      return Status(Code::kStorage,
                    "the database may not be written; make the data folder and its files writable "
                    "for the server's user");
    case Kind::kDamaged:
      return Status(Code::kStorage, "the database is damaged, restore a backup");
    case Kind::kConstraint:
    case Kind::kTaken:
      return Status(Code::kConflict,
                    "this conflicts with what is stored: it exists already, or something it names "
                    "does not exist; load it again, then try again");
    case Kind::kData:
      return Status(Code::kInvalidInput,
                    "a value is outside what the database can hold; nothing was changed");
    case Kind::kOwnFault:
      return Status(Code::kInternal, "the database failed; the log says why");
    case Kind::kOther:
      break;
  }
  return Status(Code::kStorage, "the database failed; the log says why");
}

Status Tell(const sql::SqliteFailure& failure) {
  if (failure.opening) return InFull(failure);
  // A name that is taken is everyday life.
  if (failure.kind != Kind::kTaken) {
    WarnOfDatabase(InFull(failure).message() + " (SQLite " + std::to_string(failure.code) + ")");
  }
  return WithoutDetail(failure.kind);
}

Status NotOurs(const std::filesystem::path& path) {
  const std::string folder = path.parent_path().string();
  return Status(Code::kVersion,
                path.string() +
                    " was made by another program, or by an enamel-server from before the first "
                    "release, which this one does not read: move the folder " +
                    folder + " away, or name another with --data; nothing in it was changed");
}

}  // namespace

// Of a file whose first page is still in its log the mark is 0; SchemaVersion decides then.
Status MustBeOurs(const std::filesystem::path& path, const std::string& vfs) {
  const auto id = SqliteDb::ApplicationIdIn(path, vfs);
  return !id || *id == 0 || *id == kApplicationId ? Status::Ok() : NotOurs(path);
}

Result<std::unique_ptr<SqliteDb>> OpenDatabase(const std::filesystem::path& path, DbMode mode,
                                               const std::string& vfs,
                                               std::function<bool()> fail_next) {
  ENAMEL_RETURN_IF_ERROR(MustBeOurs(path, vfs));
  sql::SqliteDbOptions options;
  options.mode = mode;
  options.setup = kSetup;
  options.application_id = kApplicationId;
  options.vfs = vfs;
  options.fail_next = std::move(fail_next);
  options.explain = Tell;
  return SqliteDb::Open(path, std::move(options));
}

int LatestSchemaVersion() { return SqliteMigrations().back().version; }

Result<int> SchemaVersion(Db& db) {
  ENAMEL_ASSIGN_OR_RETURN(const int version, db.SchemaVersion());
  const int latest = LatestSchemaVersion();
  if (version > latest) {
    return Status(Code::kVersion,
                  "the database has schema version " + std::to_string(version) +
                      ", this enamel-server knows up to " + std::to_string(latest) +
                      ": a newer enamel-server has used it. Install that one again. Or bring back "
                      "the newest backup from before the update, with enamel-server restore BACKUP "
                      "--data NEW_FOLDER; what was done since is lost");
  }
  return version;
}

}  // namespace enamel::server
