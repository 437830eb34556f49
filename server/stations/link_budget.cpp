#include "server/stations/link_budget.h"

#include <algorithm>

namespace enamel::server::stations {

std::shared_ptr<Connection> LinkBudget::Enter(const StationOfSchool& station,
                                              const std::shared_ptr<Connection>& connection) {
  MutexLock lock(mutex_);
  auto& links = parties_[station].links;
  std::erase_if(links, [](const auto& link) { return link.expired(); });
  links.push_back(connection);
  if (links.size() <= kMostLinks) return nullptr;
  std::shared_ptr<Connection> oldest = links.front().lock();
  links.pop_front();
  return oldest;
}

bool LinkBudget::Recorded(const StationOfSchool& station, uint64_t bytes, UnixMs now_ms) {
  constexpr UnixMs kPeriodMs = std::chrono::milliseconds(kPeriod).count();
  MutexLock lock(mutex_);
  Party& party = parties_[station];
  // A clock that was set back begins anew too.
  if (now_ms < party.since_ms || now_ms - party.since_ms >= kPeriodMs) {
    party.since_ms = now_ms;
    party.recorded_bytes = 0;
  }
  if (party.recorded_bytes + bytes > kMostRecordedBytes) return false;
  party.recorded_bytes += bytes;
  return true;
}

LinkBudget::Clock::duration LinkBudget::Took(const StationOfSchool& station, Clock::duration time,
                                             Clock::time_point now) {
  constexpr auto kAhead = kTimeAtOnce * 100 / kTimePercent;
  MutexLock lock(mutex_);
  auto& paid_at = parties_[station].paid_at;
  paid_at = std::max(paid_at, now) + time * 100 / kTimePercent;
  // It rests at most so long for what it took, also where its connections took it side by side.
  paid_at = std::min(paid_at, now + kAhead + kLongestRest);
  return std::max(paid_at - kAhead - now, Clock::duration::zero());
}

}  // namespace enamel::server::stations
