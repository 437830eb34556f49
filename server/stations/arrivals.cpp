#include "server/stations/arrivals.h"

#include <algorithm>

namespace enamel::server::stations {

void Arrivals::Came(const Uuid& attempt, UnixMs now_ms) {
  MutexLock lock(mutex_);
  newest_[attempt] = now_ms;
  if (newest_.size() > kMost) ForgetGone(now_ms);
  if (newest_.size() > kMost) newest_.erase(newest_.begin());
}

void Arrivals::Ended(const Uuid& attempt) {
  MutexLock lock(mutex_);
  newest_.erase(attempt);
}

void Arrivals::ForgetGone(UnixMs now_ms) {
  std::erase_if(newest_, [&](const auto& one) { return now_ms - one.second > kGoneMs; });
}

Arrivals::Counts Arrivals::Count(UnixMs now_ms) {
  MutexLock lock(mutex_);
  ForgetGone(now_ms);
  const auto late = std::ranges::count_if(
      newest_, [&](const auto& one) { return now_ms - one.second > kLateMs; });
  return {newest_.size(), static_cast<size_t>(late)};
}

void Arrivals::AddFigures(ops::MetricsText& text, UnixMs now_ms) {
  const Counts counts = Count(now_ms);
  text.Gauge("enamel_recordings_coming", "Recordings that come in at this server.",
             static_cast<double>(counts.coming));
  text.Gauge("enamel_recordings_late", "Those of them that nothing came of for 5 to 60 s.",
             static_cast<double>(counts.late));
  text.Durations("enamel_ingest_lag_seconds",
                 "Chunks of recordings, from the last byte until it is committed and answered.",
                 answers_.counts());
}

}  // namespace enamel::server::stations
