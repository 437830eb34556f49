#pragma once

#include <chrono>
#include <filesystem>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "server/storage/folder/disk.h"

namespace enamel::server {

// Keeps some of the disk free: recordings are refused before the last block is taken, so that
// signing in, erasing and the database's own housekeeping still work and the school can make room.
// Thread safety: any thread.
class SpaceGuard {
 public:
  SpaceGuard(std::filesystem::path folder, Disk& disk, uint64_t min_free_bytes,
             std::chrono::milliseconds interval)
      : folder_(std::move(folder)), disk_(disk), min_free_(min_free_bytes), interval_(interval) {}

  // Ok when there is room, or when the disk does not report it. Errors: kUnavailable, so that a
  // station keeps its recordings and comes back.
  Status Check();
  // Whether there is room for `bytes` now and min_free_bytes() stay. Errors: kStorage.
  Status RoomFor(uint64_t bytes);
  // As of the last look, at most `interval` ago.
  uint64_t FreeBytes();
  uint64_t min_free_bytes() const { return min_free_; }

 private:
  const std::filesystem::path folder_;
  Disk& disk_;
  const uint64_t min_free_;
  const std::chrono::milliseconds interval_;
  Mutex mutex_;
  std::chrono::steady_clock::time_point looked_ ENAMEL_GUARDED_BY(mutex_){};
  uint64_t free_ ENAMEL_GUARDED_BY(mutex_) = UINT64_MAX;
};

}  // namespace enamel::server
