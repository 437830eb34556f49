#include "server/live/live_board.h"

#include <algorithm>

namespace enamel::server {
namespace {

constexpr size_t kMaxAttempts = 1024;

}  // namespace

void LiveBoard::Put(const LiveSample& sample) {
  std::lock_guard lock(mutex_);
  auto [at, fresh] = latest_.try_emplace(sample.attempt, sample);
  if (!fresh && sample.tick > at->second.tick) at->second = sample;
  if (latest_.size() <= kMaxAttempts) return;
  latest_.erase(std::min_element(latest_.begin(), latest_.end(), [](const auto& a, const auto& b) {
    return a.second.received_ms < b.second.received_ms;
  }));
}

void LiveBoard::Remove(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  latest_.erase(attempt);
}

std::optional<LiveSample> LiveBoard::Latest(const Uuid& attempt) const {
  std::lock_guard lock(mutex_);
  auto at = latest_.find(attempt);
  if (at == latest_.end()) return std::nullopt;
  return at->second;
}

std::vector<LiveSample> LiveBoard::All() const {
  std::lock_guard lock(mutex_);
  std::vector<LiveSample> out;
  for (const auto& [attempt, sample] : latest_) out.push_back(sample);
  return out;
}

}  // namespace enamel::server
