#pragma once

#include <chrono>
#include <cstddef>
#include <map>

#include "common/base/mutex.h"
#include "server/ops/metrics.h"
#include "server/training/types.h"

namespace enamel::server::stations {

// Recordings that arrive here: how many, which of them are late, and how long a chunk takes from
// its last byte until it is committed and answered. A station cuts a chunk about twice a second and
// sends it at once.
//
// Bounded: the attempts whose newest chunk is no older than kGoneMs, or kMost of them. Thread
// safety: any thread.
class Arrivals {
 public:
  // Silent for longer: late. Silent for longer still: broken off, or paused, and no longer counted.
  static constexpr UnixMs kLateMs = 5'000, kGoneMs = 60'000;
  static constexpr size_t kMost = 65'536;

  // A chunk of it is committed.
  void Came(const Uuid& attempt, UnixMs now_ms);
  // It was sealed.
  void Ended(const Uuid& attempt);
  // A chunk was answered, `took` after its last byte came.
  void Answered(std::chrono::nanoseconds took) { answers_.Add(took); }

  struct Counts {
    size_t coming = 0;  // the late ones among them
    size_t late = 0;
  };
  Counts Count(UnixMs now_ms);
  // enamel_recordings_coming, enamel_recordings_late, enamel_ingest_lag_seconds.
  void AddFigures(ops::MetricsText& text, UnixMs now_ms);

 private:
  void ForgetGone(UnixMs now_ms) ENAMEL_REQUIRES(mutex_);

  Histogram answers_;
  Mutex mutex_;
  std::map<Uuid, UnixMs> newest_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::server::stations
