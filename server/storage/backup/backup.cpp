#include "server/storage/backup/backup.h"

#include <fcntl.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>
#include <vector>

#include "common/base/counted.h"
#include "common/base/fd.h"
#include "server/storage/audit/actor.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/blobs/named_blobs.h"
#include "server/storage/engine/database.h"
#include "server/storage/engine/query.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/disk.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/keys/folder_keyring.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/open_store.h"
#include "server/storage/school/school_tables.h"
#include "server/storage/store.h"
#include "server/storage/store_engine.h"
#include "server/storage/verify/manifest.h"

namespace enamel::server {
namespace {

namespace fs = std::filesystem;

Disk& DiskOf(Disk* disk) { return disk != nullptr ? *disk : SystemDisk(); }

Status MustBeFree(const fs::path& folder, const char* what) {
  std::error_code error;
  if (fs::is_empty(folder, error) || error == std::errc::no_such_file_or_directory)
    return Status::Ok();
  if (error) {
    return Status(Code::kStorage, "cannot read " + folder.string() + ": " + error.message());
  }
  return Status(Code::kConflict, "expected an absent or empty folder for the " + std::string(what) +
                                     ", found files in " + folder.string() + "; name another one");
}

// "backups/today/" names the folder "backups/today".
fs::path WithoutSlash(const fs::path& folder) {
  return folder.has_filename() ? folder : folder.parent_path();
}

fs::path PartOf(const fs::path& backup) { return backup.string() + kPartSuffix; }

// Files of a backup, and none of somebody's who has a folder of that name.
bool IsOfBackup(const std::string& name) {
  return name == "blobs" || name == "keyring" || name.starts_with("enamel.db") ||
         name.starts_with("rows.tmp") || name.starts_with(kManifestName) ||
         std::ranges::find(kIdentityFiles, name) != std::end(kIdentityFiles);
}

// Locks the folder that a backup is written to, until the descriptor closes. Removes what a killed
// backup left in it.
Result<std::unique_ptr<Fd>> TakePart(const fs::path& part, Disk& disk) {
  ENAMEL_RETURN_IF_ERROR(disk.MakeFolder(part));
  auto lock = std::make_unique<Fd>(::open(part.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock->get() < 0) {
    return Status(Code::kStorage, "cannot open " + part.string() + ": " + std::strerror(errno));
  }
  if (::flock(lock->get(), LOCK_EX | LOCK_NB) != 0) {
    return Status(Code::kUnavailable,
                  "another backup is being written to " + part.string() + "; name another folder");
  }
  std::error_code error;
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(part, error)) {
    if (!IsOfBackup(entry.path().filename().string())) {
      return Status(Code::kConflict, "expected no files but a backup's in " + part.string() +
                                         ", found " + entry.path().filename().string() +
                                         "; name another folder");
    }
    left.push_back(entry.path());
  }
  for (const fs::path& path : left) fs::remove_all(path, error);
  return lock;
}

class BackupMaker {
 public:
  explicit BackupMaker(const BackupOptions& options)
      : options_(options),
        disk_(DiskOf(options.disk)),
        whole_(WithoutSlash(options.target)),
        part_(PartOf(whole_)),
        blobs_(options.data / "blobs", disk_) {}

  Result<BackupReport> Run() {
    std::error_code error;
    ENAMEL_ASSIGN_OR_RETURN(file_, ReadDatabaseFile(options_.data));
    if (!file_ && !fs::exists(options_.data / "enamel.db", error)) {
      return Status(Code::kNotFound, "there is no enamel.db in " + options_.data.string() +
                                         "; name the server's data folder");
    }
    ENAMEL_RETURN_IF_ERROR(MustBeFree(whole_, "backup"));
    std::optional<FolderLock> shared;
    std::optional<Rewriter::Upkeep> alone;
    if (file_) {
      ENAMEL_RETURN_IF_ERROR(OpenShared());
      ENAMEL_ASSIGN_OR_RETURN(auto upkeep, store_->engine->rewriter.TakeUpkeep());
      alone.emplace(std::move(upkeep));
    } else {
      ENAMEL_ASSIGN_OR_RETURN(auto lock, TakeUpkeepLock(options_.data, FolderLock::Mode::kShared));
      shared.emplace(std::move(lock));
    }
    ENAMEL_ASSIGN_OR_RETURN(const auto ours, TakePart(part_, disk_));
    if (const Status made = Make(); !made.ok()) {
      // Nobody can use half a backup, and a full disk needs the room.
      fs::remove_all(part_, error);
      return made;
    }
    return Finished();
  }

 private:
  Status Make() {
    std::error_code error;
    std::set<Sha256> named;
    // The database first: blobs are written before the rows that name them, so every blob that the
    // copy names exists by now. No row of the copy names later blobs.
    ENAMEL_RETURN_IF_ERROR(CopyDatabase(named));
    ENAMEL_RETURN_IF_ERROR(CopyBlobs(named));
    ENAMEL_RETURN_IF_ERROR(CopyKeys());
    for (const char* name : kIdentityFiles) {
      if (fs::exists(options_.data / name, error)) ENAMEL_RETURN_IF_ERROR(Add(name, false));
    }
    // The manifest last, when all it lists is on the disk: a backup without one was not finished.
    ENAMEL_RETURN_IF_ERROR(disk_.SyncAll(part_));
    std::ranges::sort(manifest_.files, {}, &Manifest::File::path);
    ENAMEL_RETURN_IF_ERROR(disk_.Replace(part_ / kManifestName, AsBytes(ToJson(manifest_))));
    return Rename();
  }

  // To the name that says that it is whole.
  Status Rename() {
    std::error_code error;
    fs::rename(part_, whole_, error);
    if (error) {
      return Status(Code::kStorage, "cannot rename " + part_.string() + ": " + error.message());
    }
    const Status synced = disk_.SyncFolder(whole_.parent_path());
    if (!synced.ok()) fs::rename(whole_, part_, error);
    return synced;
  }

  void Tell(const std::string& what, uint64_t done, uint64_t all) const {
    if (options_.progress) options_.progress(what, done, all);
  }

  void Note(const std::string& path, const Disk::Copied& copied) {
    manifest_.files.push_back({path, copied.bytes, copied.hash});
    report_.bytes += copied.bytes;
    report_.linked += copied.linked ? 1 : 0;
  }

  Status Add(const std::string& path, bool link) {
    fs::path to = part_ / path;
    ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(to.parent_path()));
    ENAMEL_ASSIGN_OR_RETURN(auto copied, disk_.Copy(options_.data / path, to, link));
    Note(path, copied);
    return Status::Ok();
  }

  // Beside the servers.
  Status OpenShared() {
    StoreOptions open;
    open.folder = options_.data;
    ENAMEL_ASSIGN_OR_RETURN(store_, OpenStore(open));
    return Status::Ok();
  }

  // All rows of one moment, into a database as SQLite's are.
  Status CopyRowsOut(const fs::path& copy) {
    manifest_.schema = LatestSchemaVersion();
    // A database that was written has a log beside it; CopyTo leaves one file.
    const fs::path written = part_ / "rows.tmp";
    {
      ENAMEL_ASSIGN_OR_RETURN(auto db, OpenDatabase(written, DbMode::kCreate));
      ENAMEL_RETURN_IF_ERROR(db->Migrate(SqliteMigrations()));
      ENAMEL_ASSIGN_OR_RETURN(const auto tables, TablesOfSchool(*db));
      ENAMEL_RETURN_IF_ERROR(
          store_->engine->rows.Read([&](Db& from) { return CopyMoment(from, *db, tables); }));
      ENAMEL_RETURN_IF_ERROR(CopyPages(*db, copy));
    }
    for (const char* name : {"rows.tmp", "rows.tmp-wal", "rows.tmp-shm"}) {
      ENAMEL_RETURN_IF_ERROR(disk_.Remove(part_ / name));
    }
    return Status::Ok();
  }

  Status CopyMoment(Db& from, Db& to, const std::vector<Table>& tables) {
    sql::Transaction moment(from, sql::Isolation::kSnapshot);
    ENAMEL_RETURN_IF_ERROR(moment.begun());
    manifest_.created_ms = NowMs();
    sql::Transaction put(to);
    ENAMEL_RETURN_IF_ERROR(put.begun());
    const auto copied = CopyRows(from, to, tables, [this](const std::string& table, uint64_t rows) {
      Tell("rows of " + table, rows, 0);
    });
    ENAMEL_RETURN_IF_ERROR(copied.status());
    ENAMEL_RETURN_IF_ERROR(put.Commit());
    return moment.Commit();
  }

  Status CopyPages(SqliteDb& db, const fs::path& copy) {
    return db.CopyTo(copy, [&](int done, int all) {
      Tell("pages of the database", static_cast<uint64_t>(done), static_cast<uint64_t>(all));
    });
  }

  Status CopyDatabase(std::set<Sha256>& named) {
    fs::path copy = part_ / "enamel.db";
    if (file_) {
      ENAMEL_RETURN_IF_ERROR(CopyRowsOut(copy));
    } else {
      ENAMEL_ASSIGN_OR_RETURN(auto db,
                              OpenDatabase(options_.data / "enamel.db", DbMode::kReadOnly));
      ENAMEL_ASSIGN_OR_RETURN(manifest_.schema, SchemaVersion(*db));
      manifest_.created_ms = NowMs();
      ENAMEL_RETURN_IF_ERROR(CopyPages(*db, copy));
    }
    std::error_code error;
    fs::permissions(copy, fs::perms::owner_read | fs::perms::owner_write, error);
    ENAMEL_ASSIGN_OR_RETURN(auto content, disk_.Hash(copy));
    Note("enamel.db", {content, false});
    return ReadCopy(copy, named);
  }

  Status ReadCopy(const fs::path& copy, std::set<Sha256>& named) {
    ENAMEL_ASSIGN_OR_RETURN(auto db, OpenDatabase(copy, DbMode::kReadOnly));
    ENAMEL_ASSIGN_OR_RETURN(auto blobs, NamedBlobs(*db));
    named = std::move(blobs);
    ENAMEL_ASSIGN_OR_RETURN(manifest_.trail, AuditHeads(*db));
    Query q(*db,
            "SELECT (SELECT count(*) FROM people WHERE tenant = ?1), count(*), "
            "coalesce(sum(ticks), 0) FROM attempts WHERE tenant = ?1");
    if (q.Next()) {
      manifest_.people = static_cast<uint64_t>(q.Int(0));
      manifest_.attempts = static_cast<uint64_t>(q.Int(1));
      manifest_.ticks = static_cast<uint64_t>(q.Int(2));
    }
    return q.status();
  }

  Status CopyBlobs(const std::set<Sha256>& named) {
    uint64_t done = 0;
    for (const Sha256& hash : named) {
      Tell("blobs", ++done, named.size());
      if (file_ && file_->blobs) {
        ENAMEL_RETURN_IF_ERROR(FetchBlob(hash));
        continue;
      }
      const std::string path = PathOf(hash);
      if (!blobs_.Has(hash)) {
        report_.missing.push_back(hash);
        continue;
      }
      // The name is the hash: a blob that is not what its name says is reported, and left out.
      ENAMEL_RETURN_IF_ERROR(Add(path, !options_.copy));
      if (manifest_.files.back().hash == hash) continue;
      manifest_.files.pop_back();
      report_.missing.push_back(hash);
      ENAMEL_RETURN_IF_ERROR(disk_.Remove(part_ / path));
    }
    return Status::Ok();
  }

  std::string PathOf(const Sha256& hash) const {
    return blobs_.PathOf(hash).lexically_relative(options_.data).generic_string();
  }

  // From an S3 store.
  Status FetchBlob(const Sha256& hash) {
    const auto bytes = store_->engine->blobs->Get(hash);
    if (bytes.status().code() == Code::kUnavailable) return bytes.status();
    if (!bytes.ok()) {
      report_.missing.push_back(hash);
      return Status::Ok();
    }
    const fs::path to = part_ / PathOf(hash);
    ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(to.parent_path()));
    ENAMEL_RETURN_IF_ERROR(disk_.Replace(to, *bytes));
    Note(PathOf(hash), {{hash, bytes->size()}, false});
    return Status::Ok();
  }

  // Keys that are in a bucket.
  Status FetchKeys() {
    FolderKeyring inside(part_ / "keyring", disk_);
    ENAMEL_RETURN_IF_ERROR(Join(inside, *store_->engine->keyring,
                                [this](uint64_t done, uint64_t all) { Tell("keys", done, all); }));
    ENAMEL_ASSIGN_OR_RETURN(const auto people, inside.People());
    ENAMEL_ASSIGN_OR_RETURN(const auto gone, inside.Gone());
    std::vector<std::string> paths;
    for (const Uuid& person : people) paths.push_back("keyring/" + person.Text() + ".key");
    for (const Tombstone& tombstone : gone) {
      paths.push_back("keyring/gone/" + tombstone.person.Hex());
    }
    for (const std::string& path : paths) {
      ENAMEL_ASSIGN_OR_RETURN(auto content, disk_.Hash(part_ / path));
      Note(path, {content, false});
    }
    return Status::Ok();
  }

  Status CopyKeys() {
    FolderKeyring source(options_.data / "keyring", disk_);
    const bool in_bucket = file_ && file_->keys;
    if (!options_.keyring.empty()) {
      manifest_.keyring_inside = false;
      FolderKeyring apart(options_.keyring, disk_);
      return apart.MirrorFrom(in_bucket ? *store_->engine->keyring : source);
    }
    if (in_bucket) return FetchKeys();
    ENAMEL_ASSIGN_OR_RETURN(auto people, source.People());
    ENAMEL_ASSIGN_OR_RETURN(auto gone, source.Gone());
    uint64_t done = 0;
    for (const Uuid& person : people) {
      Tell("keys", ++done, people.size());
      // A copy, never a link: destroying a key overwrites it in place.
      ENAMEL_RETURN_IF_ERROR(Add("keyring/" + person.Text() + ".key", false));
    }
    for (const Tombstone& tombstone : gone) {
      ENAMEL_RETURN_IF_ERROR(Add("keyring/gone/" + tombstone.person.Hex(), false));
    }
    return Status::Ok();
  }

  Result<BackupReport> Finished() {
    report_.created_ms = manifest_.created_ms;
    report_.files = manifest_.files.size();
    report_.people = manifest_.people;
    report_.attempts = manifest_.attempts;
    report_.ticks = manifest_.ticks;
    return report_;
  }

  const BackupOptions& options_;
  Disk& disk_;
  const fs::path whole_, part_;
  FolderBlobs blobs_;
  std::optional<DatabaseFile> file_;  // none: SQLite
  std::unique_ptr<Store> store_;      // of what is not in the folder
  Manifest manifest_{.software = options_.software};
  BackupReport report_;
};

class Restorer {
 public:
  explicit Restorer(const RestoreOptions& options)
      : options_(options), disk_(DiskOf(options.disk)) {}

  Result<RestoreReport> Run() {
    ENAMEL_ASSIGN_OR_RETURN(auto manifest, ReadManifest(options_.backup));
    ENAMEL_RETURN_IF_ERROR(MayBegin(manifest));
    report_.created_ms = manifest.created_ms;
    ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(options_.data));
    // The mark before the first file: a server that finds it does not start on half of the data.
    ENAMEL_RETURN_IF_ERROR(disk_.Replace(options_.data / kRestoreMark, {}));
    ENAMEL_RETURN_IF_ERROR(CopyFiles(manifest));
    ENAMEL_RETURN_IF_ERROR(TakeKeys());
    ENAMEL_RETURN_IF_ERROR(disk_.SyncAll(options_.data));
    // After the keys: the newest list of erasures decides who comes back.
    ENAMEL_RETURN_IF_ERROR(EraseAgain());
    // Reports the findings without judging: a school may have to live with what is left.
    ENAMEL_ASSIGN_OR_RETURN(auto verified, Verify({options_.data, {}, options_.progress}));
    report_.verified = std::move(verified);
    ENAMEL_RETURN_IF_ERROR(disk_.Remove(options_.data / kRestoreMark));
    return report_;
  }

 private:
  Status MayBegin(const Manifest& manifest) const {
    int latest = LatestSchemaVersion();
    if (manifest.schema > latest) {
      return Status(Code::kVersion, "the backup's database has schema " +
                                        std::to_string(manifest.schema) +
                                        ", this enamel-server knows up to " +
                                        std::to_string(latest) + "; run the newer one");
    }
    if (!manifest.keyring_inside && options_.keyrings.empty()) {
      return Status(Code::kConflict,
                    "the keys of this backup are kept apart; name their folder with --keyring");
    }
    std::error_code error;
    for (const fs::path& keyring : options_.keyrings) {
      if (!fs::is_directory(keyring, error)) {
        return Status(Code::kNotFound, "there is no key ring " + keyring.string());
      }
    }
    return MustBeFree(options_.data, "restored data");
  }

  Status CopyFiles(const Manifest& manifest) {
    uint64_t done = 0;
    for (const Manifest::File& file : manifest.files) {
      if (options_.progress) options_.progress("files", ++done, manifest.files.size());
      fs::path to = options_.data / file.path;
      ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(to.parent_path()));
      auto copied = disk_.Copy(options_.backup / file.path, to, false);
      // Compared while it is copied: each file is read once.
      if (copied.ok() && copied->hash == file.hash) {
        ++report_.files;
        report_.bytes += copied->bytes;
        continue;
      }
      // The new disk failed, not the backup: another backup would not help.
      if (!copied.ok() && copied.status().code() != Code::kNotFound) return copied.status();
      ENAMEL_RETURN_IF_ERROR(disk_.Remove(to));
      report_.left_out.push_back(file.path + (copied.ok() ? " (damaged)" : " (cannot be read)"));
    }
    return Judge();
  }

  Status Judge() const {
    bool database = std::ranges::any_of(
        report_.left_out, [](const std::string& file) { return file.starts_with("enamel.db"); });
    // Without a blob some attempt is lost; without the database all are.
    if (report_.left_out.empty() || (options_.accept_damage && !database)) return Status::Ok();
    std::string list;
    for (size_t i = 0; i < report_.left_out.size() && i < 20; ++i)
      list += (i == 0 ? " " : ", ") + report_.left_out[i];
    if (report_.left_out.size() > 20)
      list += " and " + std::to_string(report_.left_out.size() - 20) + " more";
    return Status(
        Code::kInvalidInput,
        Counted(report_.left_out.size(), "file of the backup is", "files of the backup are") +
            " not what its manifest says:" + list + "; use another backup" +
            (database ? "" : ", or accept the loss with --accept-damage") + "; " +
            options_.data.string() + " is unfinished, empty it first");
  }

  Status TakeKeys() {
    FolderKeyring keyring(options_.data / "keyring", disk_);
    for (const fs::path& folder : options_.keyrings) {
      FolderKeyring newer(folder, disk_);
      ENAMEL_RETURN_IF_ERROR(Join(keyring, newer));
    }
    return Status::Ok();
  }

  // Sessions and codes of that time may have been ended since.
  static Status EndSessions(Store& store, const Actor& by) {
    ENAMEL_ASSIGN_OR_RETURN(const auto people, store.people.People());
    for (const Person& person : people) {
      ENAMEL_RETURN_IF_ERROR(store.sessions.EndSessionsOf(person.id, by).status());
    }
    ENAMEL_ASSIGN_OR_RETURN(const auto codes, store.stations.OpenEnrolCodes(/*now_ms=*/0));
    for (const EnrolCodeRow& code : codes) {
      ENAMEL_RETURN_IF_ERROR(store.stations.WithdrawEnrolCode(code.id, by));
    }
    return Status::Ok();
  }

  // Opening does it: what the key ring says is erased is erased.
  Status EraseAgain() {
    StoreOptions open;
    open.folder = options_.data;
    open.hold_lock = true;
    open.restoring = true;
    open.disk = options_.disk;
    // Without the store, which erases as it opens.
    ENAMEL_ASSIGN_OR_RETURN(auto before, CountPeople());
    ENAMEL_ASSIGN_OR_RETURN(auto store, OpenStore(open));
    ENAMEL_ASSIGN_OR_RETURN(auto people, store->people.People());
    report_.erased_again = before - people.size();
    const Actor by{{}, "command line"};
    ENAMEL_RETURN_IF_ERROR(EndSessions(*store, by));
    // What fails is in the log, and the server finishes it.
    (void)store->erasures.FinishErasures();
    return store->audit.NoteAudit(by, "store.restore", "",
                                  JsonOf({{"backup_of_ms", std::to_string(report_.created_ms)},
                                          {"erased_again", std::to_string(report_.erased_again)}}));
  }

  Result<size_t> CountPeople() const {
    ENAMEL_ASSIGN_OR_RETURN(auto db, OpenDatabase(options_.data / "enamel.db", DbMode::kReadOnly));
    Query q(*db, "SELECT count(*) FROM people WHERE tenant = ?1");
    size_t count = q.Next() ? static_cast<size_t>(q.Int(0)) : 0;
    ENAMEL_RETURN_IF_ERROR(q.status());
    return count;
  }

  const RestoreOptions& options_;
  Disk& disk_;
  RestoreReport report_;
};

}  // namespace

Result<BackupReport> BackUp(const BackupOptions& options) { return BackupMaker(options).Run(); }

Result<fs::path> NewBackupIn(const fs::path& folder, const std::string& name) {
  std::error_code error;
  fs::create_directories(folder, error);
  std::vector<fs::path> parts;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    // An empty one is somebody's who begins in this moment.
    const bool is_left = it->path().extension() == kPartSuffix && !fs::is_empty(it->path(), error);
    if (is_left) parts.push_back(it->path());
  }
  for (const fs::path& part : parts) {
    if (TakePart(part, SystemDisk()).ok()) fs::remove(part, error);
  }
  for (int n = 1; n < 1000; ++n) {
    const fs::path whole = folder / (n == 1 ? name : name + "-" + std::to_string(n));
    if (fs::exists(whole, error)) continue;
    if (fs::create_directory(PartOf(whole), error)) return whole;
    if (error) break;
  }
  return Status(Code::kStorage, "cannot make a folder in " + folder.string() + ": " +
                                    (error ? error.message() : "all names are taken"));
}

Result<RestoreReport> Restore(const RestoreOptions& options) { return Restorer(options).Run(); }

}  // namespace enamel::server
