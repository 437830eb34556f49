#include "server/storage/engine/data_folder.h"

#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "server/storage/engine/database_file.h"
#include "server/storage/engine/folder_lock.h"

namespace enamel::server::sqlite {
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

Status MakeDataFolder(const std::filesystem::path& folder, Disk& disk, bool restoring) {
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

}  // namespace enamel::server::sqlite
