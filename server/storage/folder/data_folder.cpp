#include "server/storage/folder/data_folder.h"

#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "common/base/file.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/folder_lock.h"

namespace enamel::server {
namespace {

constexpr size_t kMaxMarkBytes = 8192;

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

// Anybody who can read the folder has everything. A folder with other content is not ours to close:
// it may be a home, or /tmp.
Status KeepOthersOut(const std::filesystem::path& folder) {
  struct stat info {};
  constexpr mode_t kOthers = 077, kOwnerOnly = 0700;
  if (::stat(folder.c_str(), &info) != 0 || (info.st_mode & kOthers) == 0) return Status::Ok();
  char mode[8];
  std::snprintf(mode, sizeof mode, "%04o", static_cast<unsigned>(info.st_mode & 07777));
  std::error_code error;
  const bool ours = std::filesystem::exists(folder / "enamel.db", error) ||
                    std::filesystem::exists(folder / kDatabaseFile, error) ||
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

}  // namespace

Result<std::string> ReadMark(const std::filesystem::path& file) {
  ENAMEL_ASSIGN_OR_RETURN(const Bytes bytes, ReadFile(file, kMaxMarkBytes));
  std::string text(AsText(bytes));
  while (text.ends_with('\n')) text.pop_back();
  return text;
}

Status MakeDataFolder(const std::filesystem::path& folder, Disk& disk, bool restoring) {
  if (Status made = disk.MakeFolder(folder); !made.ok()) {
    return Status(Code::kStorage, "cannot make the data folder " + folder.string() + ": " +
                                      made.message() + "; name a folder this user may write");
  }
  ENAMEL_RETURN_IF_ERROR(MustNotBeRootForAnother(folder));
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    return Status(Code::kStorage, "the data folder " + folder.string() + " is not writable: " +
                                      std::strerror(errno) + "; name a folder this user may write");
  }
  if (!restoring && std::filesystem::exists(folder / kRestoreMark)) {
    return Status(Code::kConflict, folder.string() +
                                       " holds a restore that did not finish; empty the folder and "
                                       "restore again");
  }
  if (!restoring && std::filesystem::exists(folder / kMoveMark)) {
    return Status(Code::kConflict, folder.string() +
                                       " holds a move that did not finish; repeat the move "
                                       "command, which continues where it stopped");
  }
  if (const auto to = ReadMark(folder / kMovedMark); to.ok() && !restoring) {
    std::error_code unseen;
    if (std::filesystem::exists(std::filesystem::path(*to) / kMoveMark, unseen)) {
      return Status(Code::kConflict,
                    "this school is being moved to " + *to +
                        "; repeat the move command, or, to use this folder again, delete " +
                        (folder / kMovedMark).string());
    }
    return Status(Code::kConflict,
                  "this school was moved to " + *to +
                      "; use that place. To use this folder again, without changes made there and "
                      "with people who were erased there, delete " +
                      (folder / kMovedMark).string());
  }
  ENAMEL_RETURN_IF_ERROR(KeepOthersOut(folder));
  ENAMEL_RETURN_IF_ERROR(disk.MakeFolder(folder / "blobs"));
  // A process that was killed may have left entries unsynced.
  ENAMEL_RETURN_IF_ERROR(disk.SyncFolder(folder / "blobs"));
  return disk.SyncFolder(folder);
}

}  // namespace enamel::server
