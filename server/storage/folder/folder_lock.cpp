#include "server/storage/folder/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace enamel::server {

FolderLock::~FolderLock() {
  if (fd_ >= 0) ::close(fd_);
}

Result<FolderLock> FolderLock::Take(const std::filesystem::path& file, Mode mode,
                                    const std::string& busy) {
  int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0) {
    return Status(Code::kStorage, "cannot open " + file.string() + ": " + std::strerror(errno) +
                                      "; name a folder this user may write");
  }
  FolderLock lock(fd);
  // flock instead of a file's existence: the system releases it when the process dies, however it
  // dies.
  if (::flock(fd, (mode == Mode::kShared ? LOCK_SH : LOCK_EX) | LOCK_NB) != 0) {
    return Status(Code::kUnavailable, busy);
  }
  return lock;
}

Result<FolderLock> TakeUpkeepLock(const std::filesystem::path& folder, FolderLock::Mode mode) {
  return FolderLock::Take(
      folder / kUpkeepLock, mode,
      mode == FolderLock::Mode::kShared
          ? "recordings are being removed from " + folder.string() +
                " just now; try again when that is done"
          : "a backup of " + folder.string() + " is being made; try again when it is done");
}

// Asked by trying: a lock tells nobody who holds it.
bool IsUpkeepAlone(const std::filesystem::path& folder) {
  return TakeUpkeepLock(folder, FolderLock::Mode::kShared).status().code() == Code::kUnavailable;
}

}  // namespace enamel::server
