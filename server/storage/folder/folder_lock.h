#pragma once

#include <filesystem>
#include <utility>

#include "common/base/result.h"

namespace enamel::server {

// Names in a data folder besides the database, blobs/ and keyring/.
inline constexpr char kServerLock[] = "LOCK";    // held by the running server
inline constexpr char kUpkeepLock[] = "UPKEEP";  // held by a backup, or by what removes blobs
inline constexpr char kRestoreMark[] = "RESTORE-UNFINISHED";
inline constexpr char kMoveMark[] = "MOVE-UNFINISHED";  // in a folder that a school is moved to
// In a folder that a school was moved from, with its new place: if both continued, there would be
// two schools.
inline constexpr char kMovedMark[] = "MOVED";
// What makes it this server and no other; equal on all servers of a school. The certificate last:
// where it is, its key is.
inline constexpr const char* kIdentityFiles[] = {"ticket.key", "station.key", "station.crt"};

// An advisory lock (flock) on a file of the data folder, until destroyed. A killed process holds
// none. Thread safety: a value.
class FolderLock {
 public:
  enum class Mode { kShared, kExclusive };
  // Does not wait. Errors: kUnavailable (somebody holds it in a way that excludes this one: says
  // `busy`), kStorage.
  static Result<FolderLock> Take(const std::filesystem::path& file, Mode mode,
                                 const std::string& busy);
  FolderLock() = default;
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;

 private:
  explicit FolderLock(int fd) : fd_(fd) {}
  int fd_ = -1;
};

// Backups share it; what removes blobs or rewrites the database needs it alone.
Result<FolderLock> TakeUpkeepLock(const std::filesystem::path& folder, FolderLock::Mode mode);
// Somebody has it alone.
bool IsUpkeepAlone(const std::filesystem::path& folder);

}  // namespace enamel::server
