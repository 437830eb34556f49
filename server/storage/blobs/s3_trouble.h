#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "common/base/mutex.h"
#include "common/base/result.h"

namespace enamel::server {

// The health of an S3 store, from the results of its calls. The log has each failure in full, at
// most once a minute of a kind; callers get it without host and bucket. Thread safety: any thread.
class S3Trouble {
 public:
  // `what` it is the store of, in messages: "blobs".
  S3Trouble(std::string what, std::function<int64_t()> now_ms)
      : what_(std::move(what)), now_ms_(std::move(now_ms)) {}
  // Notes a call's status; returns it as callers may read it.
  Status Told(const Status& status);
  // Since the last call that was done.
  Status Problem() const;
  // Whether it is time to ask the store although nobody needs it: otherwise nobody would notice that
  // it fails, or works again.
  bool IsDue() const;
  static constexpr int64_t kLookEveryMs = 2'000;
  // How long such a question may take.
  static constexpr std::chrono::seconds kLookWithin{3};

 private:
  const std::string what_;
  const std::function<int64_t()> now_ms_;
  mutable Mutex mutex_;
  Status problem_ ENAMEL_GUARDED_BY(mutex_);
  int64_t logged_ms_ ENAMEL_GUARDED_BY(mutex_) = 0;
  int64_t told_ms_ ENAMEL_GUARDED_BY(mutex_) = 0;
};

}  // namespace enamel::server
