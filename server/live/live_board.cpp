#include "server/live/live_board.h"

#include <algorithm>

namespace enamel::server {
namespace {

constexpr size_t kMaxAttempts = 1024;

void AppendRow(const LiveSample& sample, std::string& out) {
  out += '[' + std::to_string(sample.tick);
  for (int32_t value : sample.anchor_um) out += ',' + std::to_string(value);
  for (int32_t value : sample.force_mn) out += ',' + std::to_string(value);
  out += ',' + std::to_string(sample.flags) + ']';
}

std::string EventOf(std::span<const LiveSample> samples) {
  std::string out = "{\"tick\":" + std::to_string(samples.back().tick) + ",\"rows\":[";
  for (const LiveSample& sample : samples) {
    if (&sample != samples.data()) out += ',';
    AppendRow(sample, out);
  }
  return out + "]}";
}

}  // namespace

void LiveBoard::Put(std::span<const LiveSample> samples) {
  if (samples.empty()) return;
  const LiveSample& last = samples.back();
  bool watched = Watched(last.attempt);
  auto event = watched ? std::make_shared<const std::string>(EventOf(samples)) : nullptr;
  std::lock_guard lock(mutex_);
  auto [at, fresh] = latest_.try_emplace(last.attempt, last);
  if (!fresh && last.tick <= at->second.tick) return;
  at->second = last;
  if (auto channel = channels_.find(last.attempt); event && channel != channels_.end()) {
    channel->second.event = std::move(event);
    ++channel->second.version;
  }
  if (latest_.size() <= kMaxAttempts) return;
  latest_.erase(std::min_element(latest_.begin(), latest_.end(), [](const auto& a, const auto& b) {
    return a.second.received_ms < b.second.received_ms;
  }));
}

void LiveBoard::Remove(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  latest_.erase(attempt);
  if (auto channel = channels_.find(attempt); channel != channels_.end()) {
    channel->second.ended = true;
  }
}

std::optional<LiveSample> LiveBoard::Latest(const Uuid& attempt) const {
  std::lock_guard lock(mutex_);
  auto at = latest_.find(attempt);
  if (at == latest_.end()) return std::nullopt;
  return at->second;
}

bool LiveBoard::Watched(const Uuid& attempt) const {
  if (watches_ == 0) return false;
  std::lock_guard lock(mutex_);
  return channels_.contains(attempt);
}

std::unique_ptr<LiveWatch> LiveBoard::Watch(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  if (watches_ >= kMaxWatches) return nullptr;
  ++watches_;
  ++channels_[attempt].watches;
  return std::make_unique<LiveWatch>(*this, attempt);
}

void LiveBoard::Leave(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  --watches_;
  auto channel = channels_.find(attempt);
  if (--channel->second.watches == 0) channels_.erase(channel);
}

std::shared_ptr<const std::string> LiveWatch::Next() {
  std::lock_guard lock(board_.mutex_);
  const LiveBoard::Channel& channel = board_.channels_.at(attempt_);
  ended_ = channel.ended;
  if (channel.version == seen_) return nullptr;
  seen_ = channel.version;
  return channel.event;
}

}  // namespace enamel::server
