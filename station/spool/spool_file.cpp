#include "station/spool/spool_file.h"

#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "station/spool/spool.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

int LatestVersion() { return SpoolMigrations().back().version; }

using Mode = sql::SqliteDbOptions::Mode;

sql::SqliteDbOptions In(Mode mode) {
  sql::SqliteDbOptions out;
  out.application_id = kSpoolMark;
  out.mode = mode;
  return out;
}

// Also opens a file that is cut short, or whose schema has errors, to read what it can.
sql::SqliteDbOptions AsItIs(Mode mode) {
  sql::SqliteDbOptions out = In(mode);
  out.damaged = true;
  return out;
}

// Recordings identify people: only the owner may read them.
void KeepOthersOut(const fs::path& file) {
  std::error_code error;
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write, error);
}

Status Told(const fs::path& spool, const char* doing, const sql::SqliteFailure& failure) {
  return Status(Code::kStorage,
                "spool " + spool.string() + ": " + doing + " failed (" +
                    (failure.words.empty() ? "there is none" : failure.words) + "); " +
                    WhatToDoAbout(failure.kind),
                failure.kind == SpoolTrouble::kDamaged ? kDamagedSpool : "");
}

}  // namespace

Status NotOurs(const fs::path& spool) {
  return Status(Code::kVersion,
                "spool " + spool.string() +
                    " was made by an earlier Enamel, or by another program: this one cannot read "
                    "it, and changes nothing in it. Upload what it holds with the program that "
                    "made it. Then move the file away, or choose another folder with --data");
}

std::string WhatToDoAbout(SpoolTrouble trouble) {
  switch (trouble) {
    case SpoolTrouble::kFull:
      return "the disk is full: free space there";
    case SpoolTrouble::kNotWritable:
      return "make the folder writable for this user, or choose another with --data";
    case SpoolTrouble::kDamaged:
      return "the file is damaged: 'enamel-station spool verify' says which recordings are hit, "
             "'enamel-station spool salvage --out FOLDER' saves what can be read of it";
    case SpoolTrouble::kBusy:
      return "another enamel-station is using it: wait until that one has ended";
    case SpoolTrouble::kConstraint:
    case SpoolTrouble::kTaken:
    case SpoolTrouble::kInterrupted:
    case SpoolTrouble::kOther:
      break;
  }
  return "see the system's log for this disk";
}

SpoolFile::~SpoolFile() {
  db_.reset();
  std::error_code error;
  if (!copy_.empty()) fs::remove_all(copy_, error);
}

Status SpoolFile::Fail(const char* doing) const { return Told(path_, doing, db_->failure()); }

Status SpoolFile::Run(sql::Query& query, const char* doing) {
  return query.Run().ok() ? Status::Ok() : Fail(doing);
}

Status SpoolFile::OpenDb(const fs::path& file, sql::SqliteDbOptions options, const char* doing) {
  // The previous connection may still hold the file.
  db_.reset();
  // Only while opening: Fail reports later errors, and knows the operation.
  options.explain = [this, doing](const sql::SqliteFailure& failure) {
    if (failure.opening) opening_ = failure.kind;
    return failure.opening ? Told(path_, doing, failure)
                           : Status(sql::CodeOf(failure.kind), failure.words);
  };
  ENAMEL_ASSIGN_OR_RETURN(db_, sql::SqliteDb::Open(file, std::move(options)));
  return Status::Ok();
}

// Finds a lost file, which must not be taken for a new spool: empty, or missing with its log
// present. SQLite would start a new file and discard the log.
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

// Creates the whole file at once, so that an empty one is never a new one. Does nothing if another
// process was first.
Status SpoolFile::Create() {
  const fs::path made = path_.string() + ".new-" + std::to_string(::getpid());
  Status done;
  {
    SpoolFile fresh(made);
    done = fresh.OpenDb(made, In(Mode::kCreate), "creating");
    KeepOthersOut(made);
    if (done.ok()) done = fresh.BringUpToDate(0);
  }
  if (!done.ok()) {
    std::error_code error;
    for (const char* end : {"", "-wal", "-shm"}) fs::remove(made.string() + end, error);
    return done;
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
                                          "): " + WhatToDoAbout(SpoolTrouble::kNotWritable));
}

Status SpoolFile::CheckVersion(int version) const {
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
  // Before it is opened, because its log gets the same mode.
  KeepOthersOut(out->path_);
  ENAMEL_RETURN_IF_ERROR(out->OpenDb(out->path_, In(Mode::kExisting), "opening"));
  ENAMEL_ASSIGN_OR_RETURN(const int version, out->Version());
  ENAMEL_RETURN_IF_ERROR(out->CheckVersion(version));
  if (version < LatestVersion()) ENAMEL_RETURN_IF_ERROR(out->BringUpToDate(version));
  if (out->db_->read_only()) {
    return Status(Code::kStorage, "spool " + out->path_.string() + " is not writable: " +
                                      WhatToDoAbout(SpoolTrouble::kNotWritable));
  }
  return out;
}

// Errors also: kVersion, it is another program's.
Result<int> SpoolFile::Version() {
  auto version = db_->SchemaVersion();
  if (version.ok()) return version;
  return version.status().code() == Code::kVersion ? NotOurs(path_) : Fail("reading its version");
}

// Reads a copy if the file cannot be read in place (its log needs a writable folder, or it is of an
// older version).
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
  return OpenDb(copy_ / kSpoolFile, AsItIs(Mode::kExisting), "opening");
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
  Status opened = out->OpenDb(out->path_, AsItIs(Mode::kReadOnly), "opening");
  if (!opened.ok() && out->opening_ == SpoolTrouble::kNotWritable) opened = out->OpenCopy();
  ENAMEL_RETURN_IF_ERROR(opened);
  ENAMEL_ASSIGN_OR_RETURN(const int version, out->Version());
  ENAMEL_RETURN_IF_ERROR(out->CheckVersion(version));
  if (version < LatestVersion()) {
    if (out->copy_.empty()) ENAMEL_RETURN_IF_ERROR(out->OpenCopy());
    ENAMEL_RETURN_IF_ERROR(out->BringUpToDate(version));
  }
  return out;
}

// `version` was read before the transaction and is only for messages: Migrate reads it again
// inside.
Status SpoolFile::BringUpToDate(int version) {
  if (db_->Migrate(SpoolMigrations()).ok()) return Status::Ok();
  const std::string doing = version == 0
                                ? "creating its tables"
                                : "bringing it to version " + std::to_string(LatestVersion());
  return Fail(doing.c_str());
}

Status SpoolFile::TestWrite() {
  // Writes its first page although the value is the same.
  const std::string same = "PRAGMA user_version = " + std::to_string(LatestVersion());
  return db_->Exec(same.c_str()).ok() ? Status::Ok() : Fail("a test write");
}

}  // namespace enamel::station
