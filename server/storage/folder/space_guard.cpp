#include "server/storage/folder/space_guard.h"

#include <string>

namespace enamel::server {

uint64_t SpaceGuard::FreeBytes() {
  MutexLock lock(mutex_);
  auto now = std::chrono::steady_clock::now();
  // Every chunk asks; the disk is read about once a second.
  if (looked_ != decltype(looked_){} && now - looked_ < interval_) return free_;
  looked_ = now;
  auto free = disk_.FreeBytes(folder_);
  // A disk that does not tell is no reason to refuse recordings.
  free_ = free.ok() ? *free : UINT64_MAX;
  return free_;
}

// Asks the disk again: for something this large a second-old value is too old.
Status SpaceGuard::RoomFor(uint64_t bytes) {
  auto free = disk_.FreeBytes(folder_);
  if (!free.ok() || *free >= bytes + min_free_) return Status::Ok();
  return Status(Code::kStorage, "expected " + std::to_string(((bytes + min_free_) >> 20) + 1) +
                                    " MiB free on the data folder's disk, found " +
                                    std::to_string(*free >> 20) + " MiB; make room");
}

Status SpaceGuard::Check() {
  if (min_free_ == 0) return Status::Ok();
  uint64_t free = FreeBytes();
  if (free >= min_free_) return Status::Ok();
  return Status(Code::kUnavailable,
                "the server's disk is full: " + std::to_string(free >> 20) + " MiB are free, " +
                    std::to_string(min_free_ >> 20) +
                    " MiB are kept free; recordings wait at the stations until there is room");
}

}  // namespace enamel::server
