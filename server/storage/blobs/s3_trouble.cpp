#include "server/storage/blobs/s3_trouble.h"

#include <spdlog/spdlog.h>

namespace enamel::server {
namespace {
constexpr int64_t kLogEveryMs = 60'000;
}  // namespace

Status S3Trouble::Told(const Status& status) {
  const bool works = status.ok() || status.code() == Code::kNotFound;
  {
    MutexLock lock(mutex_);
    const int64_t now = now_ms_();
    if (works && !problem_.ok()) spdlog::info("the store of {} works again", what_);
    if (!works && (problem_.code() != status.code() || now - logged_ms_ >= kLogEveryMs)) {
      spdlog::warn("{}: {}", what_, status.message());
      logged_ms_ = now;
    }
    problem_ = works ? Status::Ok() : status;
    told_ms_ = now;
  }
  if (works || status.code() == Code::kTooLarge) return status;
  if (status.code() == Code::kUnavailable) {
    return Status(Code::kUnavailable,
                  "the store of " + what_ + " cannot be reached or is overloaded; try again later");
  }
  return Status(Code::kStorage,
                "the store of " + what_ + " refuses, is full or fails; the server's log says why");
}

bool S3Trouble::IsDue() const {
  MutexLock lock(mutex_);
  const int64_t since_ms = now_ms_() - told_ms_;
  // A clock that was set back shows as well.
  return since_ms < 0 || since_ms >= kLookEveryMs;
}

Status S3Trouble::Problem() const {
  MutexLock lock(mutex_);
  return problem_;
}

}  // namespace enamel::server
