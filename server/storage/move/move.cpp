#include "server/storage/move/move.h"

#include <algorithm>

#include "common/base/counted.h"
#include "server/storage/audit/actor.h"
#include "server/storage/blobs/named_blobs.h"
#include "server/storage/engine/database.h"
#include "server/storage/engine/move_marks.h"
#include "server/storage/engine/pg_database.h"
#include "server/storage/engine/query.h"
#include "server/storage/folder/data_folder.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/disk.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/open_store.h"
#include "server/storage/store.h"
#include "server/storage/store_engine.h"

namespace enamel::server {
namespace {

namespace fs = std::filesystem;

// The text of a mark: the old place, or the new one.
std::string PathText(const fs::path& folder) {
  std::error_code error;
  return fs::weakly_canonical(fs::absolute(folder, error), error).string();
}

// Nothing in it, or what BeginMove has left that was cut off before its mark.
bool IsEmptyOrJustMade(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    const bool made = name.starts_with(std::string(kMoveMark) + ".tmp") ||
                      (name == "blobs" && fs::is_empty(it->path(), error));
    if (!made) return false;
  }
  return !error;
}

Status MustNotBeMovedElsewhere(const fs::path& from, const fs::path& to) {
  std::error_code error;
  const auto moved = ReadMark(from / kMovedMark);
  if (moved.status().code() == Code::kNotFound) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(moved.status());
  if (*moved == PathText(to) && fs::exists(to / kMoveMark, error)) return Status::Ok();
  return Status(Code::kConflict,
                "this school was moved already, to " + *moved + "; move it from there");
}

class Mover {
 public:
  explicit Mover(const MoveOptions& options)
      : options_(options), disk_(options.disk != nullptr ? *options.disk : SystemDisk()) {}

  Result<MoveReport> Run() {
    ENAMEL_ASSIGN_OR_RETURN(const auto mark, ReadMark(options_.to / kMoveMark));
    if (mark != PathText(options_.from)) {
      return Status(Code::kConflict, "expected a move from " + options_.from.string() + " in " +
                                         options_.to.string() + ", found one from " + mark);
    }
    // Its lock first: of two that move the same, the second must not touch the first one's mark.
    ENAMEL_RETURN_IF_ERROR(OpenSource());
    ENAMEL_RETURN_IF_ERROR(MustNotBeMovedElsewhere(options_.from, options_.to));
    // From now on no command opens the old place; one that has it open is noticed
    // (MustBeUnchanged).
    ENAMEL_RETURN_IF_ERROR(
        disk_.Replace(options_.from / kMovedMark, AsBytes(PathText(options_.to) + "\n")));
    Status moved = CloseToOthers(true);
    if (moved.ok()) moved = MoveAll();
    if (!moved.ok()) {
      // The school continues in the old place, unless the new place may be open already; after a
      // crash, that is up to the person who reads the mark.
      if (!opens_) {
        (void)CloseToOthers(false);
        (void)disk_.Remove(options_.from / kMovedMark);
      }
      return moved;
    }
    return std::move(report_);
  }

 private:
  // The old place, to the folders of its other servers.
  Status CloseToOthers(bool close) {
    if (!source_->shared) return Status::Ok();
    return source_->engine->rows.Write([&](Db& db) {
      return close ? PutMoveRow(db, MoveRow::kAway) : DropMoveRow(db, MoveRow::kAway);
    });
  }

  // The new place, to the same.
  Status OpenToOthers() {
    if (!target_->shared) return Status::Ok();
    return target_->engine->rows.Write([&](Db& db) -> Status {
      // It may have been the place before last.
      ENAMEL_RETURN_IF_ERROR(DropMoveRow(db, MoveRow::kAway));
      return DropMoveRow(db, MoveRow::kComing);
    });
  }

  Status MoveAll() {
    ENAMEL_RETURN_IF_ERROR(MoveRows());
    ENAMEL_ASSIGN_OR_RETURN(target_, Open(options_.to, /*restoring=*/true));
    ENAMEL_RETURN_IF_ERROR(MoveBlobs());
    ENAMEL_RETURN_IF_ERROR(MoveKeys());
    ENAMEL_RETURN_IF_ERROR(MustBeUnchanged());
    ENAMEL_RETURN_IF_ERROR(OpenToOthers());
    target_.reset();
    ENAMEL_RETURN_IF_ERROR(disk_.SyncAll(options_.to));
    opens_ = true;
    return disk_.Remove(options_.to / kMoveMark);
  }

  void Tell(const std::string& what, uint64_t done, uint64_t all) const {
    if (options_.progress) options_.progress(what, done, all);
  }

  // Holding its lock.
  Result<std::unique_ptr<Store>> Open(const fs::path& folder, bool restoring) const {
    StoreOptions open;
    open.folder = folder;
    open.hold_lock = true;
    open.restoring = restoring;
    open.disk = options_.disk;
    return OpenStore(open);
  }

  Status OpenSource() {
    // The mark of an earlier try of this move does not close it for us; anything else that does,
    // does.
    std::error_code error;
    const bool again = fs::exists(options_.from / kMovedMark, error) &&
                       !fs::exists(options_.from / kRestoreMark, error) &&
                       !fs::exists(options_.from / kMoveMark, error);
    ENAMEL_ASSIGN_OR_RETURN(source_, Open(options_.from, /*restoring=*/again));
    ENAMEL_RETURN_IF_ERROR(source_->engine->sealed->Finish());
    return MustBeAlone();
  }

  Status MustBeAlone() {
    // Its own name among them is of a server that has just ended.
    ENAMEL_ASSIGN_OR_RETURN(const size_t others, source_->live.OtherServers());
    if (others == 0) return MustHaveNoSchools();
    return Status(Code::kConflict, "expected that no server of the school runs, " +
                                       Counted(others, "does", "others do") +
                                       " or did within the last 20 s; stop them all, then move");
  }

  // They would be created again beside the new place, and be empty there.
  Status MustHaveNoSchools() {
    ENAMEL_ASSIGN_OR_RETURN(const auto schools, source_->schools.Schools());
    if (schools.empty()) return Status::Ok();
    return Status(
        Code::kConflict,
        "expected an installation of one school, found " + Counted(schools.size(), "other school") +
            ", " + schools.front().name +
            " first; back each up (enamel-server backup) and delete it here (enamel-server "
            "school delete), or leave the installation where it is",
        "schools");
  }

  Status MoveRows() {
    ENAMEL_ASSIGN_OR_RETURN(const auto source_file, ReadDatabaseFile(options_.from));
    ENAMEL_ASSIGN_OR_RETURN(const auto target_file, ReadDatabaseFile(options_.to));
    if (source_file && target_file) {
      return Status(Code::kInvalidInput,
                    "expected one of the two places to be a folder (SQLite), both are PostgreSQL; "
                    "copy the database with its own tools, pg_dump or a standby");
    }
    ENAMEL_ASSIGN_OR_RETURN(auto db, OpenTarget(target_file));
    if (source_file) {
      ENAMEL_ASSIGN_OR_RETURN(tables_, TablesOfSchool(*db));
    } else {
      ENAMEL_RETURN_IF_ERROR(source_->engine->rows.Read([&](Db& from) -> Status {
        ENAMEL_ASSIGN_OR_RETURN(tables_, TablesOfSchool(from));
        return Status::Ok();
      }));
    }
    ENAMEL_ASSIGN_OR_RETURN(const bool there, HasRows(*db));
    // In the old place, before it is read: a row in the new one would make the two differ for a try
    // that is repeated.
    if (!there) {
      ENAMEL_RETURN_IF_ERROR(
          source_->audit.NoteAudit(Actor{{}, "command line"}, "store.move", "", "{}"));
    }
    ENAMEL_RETURN_IF_ERROR(there ? ReadSource() : CopyTo(*db, target_file.has_value()));
    ENAMEL_ASSIGN_OR_RETURN(const auto found, DigestRows(*db, tables_, Progress("compared")));
    const std::string differ = Differences(report_.tables, found);
    if (differ.empty()) return Status::Ok();
    if (!there) {
      return Status(Code::kStorage, "the new place gives back other rows than were put: " + differ);
    }
    return Status(Code::kConflict,
                  "expected a new place for the rows, found other rows there: " + differ +
                      ". Name another schema, or, where they are what an earlier try of this move "
                      "left before the old place changed, drop that schema");
  }

  // All rows of the old place, as of one moment. The transaction ends as soon as they are read: an
  // engine may end one that waits for long.
  Status InOneMoment(const std::function<Status(Db&)>& read) {
    return source_->engine->rows.Read([&](Db& from) -> Status {
      sql::Transaction moment(from, sql::Isolation::kSnapshot);
      ENAMEL_RETURN_IF_ERROR(moment.begun());
      ENAMEL_RETURN_IF_ERROR(read(from));
      return moment.Commit();
    });
  }

  Status ReadSource() {
    return InOneMoment([&](Db& from) -> Status {
      ENAMEL_ASSIGN_OR_RETURN(report_.tables, DigestRows(from, tables_, Progress("compared")));
      return Status::Ok();
    });
  }

  // `shared`: other servers' folders can name the new place.
  Status CopyTo(Db& to, bool shared) {
    sql::Transaction put(to);
    ENAMEL_RETURN_IF_ERROR(put.begun());
    ENAMEL_RETURN_IF_ERROR(InOneMoment([&](Db& from) -> Status {
      ENAMEL_ASSIGN_OR_RETURN(report_.tables, CopyRows(from, to, tables_, Progress("moved")));
      return Status::Ok();
    }));
    // With the rows, so that nobody opens them before the blobs are there.
    if (shared) ENAMEL_RETURN_IF_ERROR(PutMoveRow(to, MoveRow::kComing));
    return put.Commit();
  }

  // By an earlier try.
  static Result<bool> HasRows(Db& to) {
    sql::Query any(to, "SELECT 1 FROM audit LIMIT 1");
    const bool has_rows = any.Next();
    ENAMEL_RETURN_IF_ERROR(any.status());
    return has_rows;
  }

  // What somebody changed in the old place while it was moved would be lost.
  Status MustBeUnchanged() {
    const auto moved = report_.tables;
    ENAMEL_RETURN_IF_ERROR(ReadSource());
    const std::string differ = Differences(moved, report_.tables);
    if (differ.empty()) return MustBeAlone();
    return Status(
        Code::kConflict,
        "the old place has changed while it was moved: " + differ +
            ". See that no server, worker or command uses it, then move into a new place: "
            "another folder, and another schema of the database");
  }

  Result<std::unique_ptr<Db>> OpenTarget(const std::optional<DatabaseFile>& file) {
    if (file) {
      ENAMEL_ASSIGN_OR_RETURN(auto db,
                              OpenPgDatabase(file->server, file->schema, /*read_only=*/false, {}));
      ENAMEL_RETURN_IF_ERROR(SchemaVersion(*db).status());
      ENAMEL_RETURN_IF_ERROR(db->Migrate(PgMigrations()));
      return db;
    }
    // Leftovers of an earlier try: deleting them is quicker than examining them.
    for (const char* name : {"enamel.db", "enamel.db-wal", "enamel.db-shm"}) {
      ENAMEL_RETURN_IF_ERROR(disk_.Remove(options_.to / name));
    }
    ENAMEL_ASSIGN_OR_RETURN(auto db, OpenDatabase(options_.to / "enamel.db", DbMode::kCreate));
    ENAMEL_RETURN_IF_ERROR(db->Migrate(SqliteMigrations()));
    return std::unique_ptr<Db>(std::move(db));
  }

  RowProgress Progress(const char* what) {
    return [this, what](const std::string& table, uint64_t rows) {
      Tell(std::string("rows of ") + table + " " + what, rows, 0);
    };
  }

  Status MoveBlobs() {
    std::set<Sha256> named;
    ENAMEL_RETURN_IF_ERROR(source_->engine->rows.Read([&](Db& db) -> Status {
      ENAMEL_ASSIGN_OR_RETURN(named, NamedBlobs(db));
      return Status::Ok();
    }));
    uint64_t done = 0;
    for (const Sha256& hash : named) {
      Tell("blobs", ++done, named.size());
      ENAMEL_RETURN_IF_ERROR(MoveBlob(hash));
    }
    if (report_.missing.empty() || options_.accept_damage) return Status::Ok();
    return Status(Code::kStorage,
                  Counted(report_.missing.size(), "blob that the rows name is",
                          "blobs that the rows name are") +
                      " missing or damaged in the old place, the first is " +
                      report_.missing.front().Hex() +
                      "; restore them from a backup, or accept the loss with --accept-damage. Then "
                      "repeat the command: it continues from here");
  }

  Status MoveBlob(const Sha256& hash) {
    // Get compares content and name. An earlier try may have put it.
    if (target_->engine->blobs->Has(hash)) {
      if (const auto there = target_->engine->blobs->Get(hash); there.ok()) {
        ++report_.there_before;
        return Count(*there);
      }
    }
    const auto bytes = source_->engine->blobs->Get(hash);
    if (bytes.status().code() == Code::kUnavailable) return bytes.status();
    if (!bytes.ok()) {
      report_.missing.push_back(hash);
      return Status::Ok();
    }
    ENAMEL_RETURN_IF_ERROR(target_->engine->blobs->Put(*bytes).status());
    ENAMEL_ASSIGN_OR_RETURN(const Bytes back, target_->engine->blobs->Get(hash));
    return Count(back);
  }

  Status Count(const Bytes& blob) {
    ++report_.blobs;
    report_.bytes += blob.size();
    return Status::Ok();
  }

  Status MoveKeys() {
    Keyring& from = *source_->engine->keyring;
    Keyring& to = *target_->engine->keyring;
    ENAMEL_RETURN_IF_ERROR(
        Join(to, from, [&](uint64_t done, uint64_t all) { Tell("keys", done, all); }));
    ENAMEL_ASSIGN_OR_RETURN(const auto people, from.People());
    for (const Uuid& person : people) {
      ENAMEL_ASSIGN_OR_RETURN(const DataKey expected, from.Find(person));
      ENAMEL_ASSIGN_OR_RETURN(const DataKey found, to.Find(person));
      if (std::ranges::equal(expected.view(), found.view())) continue;
      return Status(Code::kStorage, "the new key ring has another key of person " + person.Text() +
                                        "; name a new place for the keys");
    }
    ENAMEL_ASSIGN_OR_RETURN(const auto gone, from.Gone());
    report_.keys = people.size();
    report_.erased = gone.size();
    return Status::Ok();
  }

  const MoveOptions& options_;
  Disk& disk_;
  std::unique_ptr<Store> source_, target_;
  std::vector<Table> tables_;
  MoveReport report_;
  bool opens_ = false;  // the new place, from now on
};

}  // namespace

Status BeginMove(const fs::path& from, const fs::path& to, Disk& disk) {
  std::error_code error;
  ENAMEL_RETURN_IF_ERROR(MustNotBeMovedElsewhere(from, to));
  if (PathText(to).starts_with(PathText(from) + "/")) {
    return Status(
        Code::kInvalidInput,
        "expected a folder outside of " + from.string() + " to move to, found " + to.string(),
        "to");
  }
  const auto mark = ReadMark(to / kMoveMark);
  if (mark.ok() && *mark == PathText(from)) return Status::Ok();
  if (mark.ok()) {
    return Status(Code::kConflict,
                  to.string() + " holds a move from " + *mark +
                      " that did not finish; finish that one, or empty the folder");
  }
  const bool free = !fs::exists(to, error) || IsEmptyOrJustMade(to);
  if (!free) {
    return Status(Code::kConflict,
                  "expected an absent or empty folder to move to, found files in " + to.string() +
                      "; name another one");
  }
  // As a data folder has to be, while it is empty still.
  ENAMEL_RETURN_IF_ERROR(MakeDataFolder(to, disk, /*restoring=*/true));
  // Before anything that a server could start on.
  return disk.Replace(to / kMoveMark, AsBytes(PathText(from) + "\n"));
}

Result<MoveReport> MoveSchool(const MoveOptions& options) { return Mover(options).Run(); }

}  // namespace enamel::server
