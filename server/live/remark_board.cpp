#include "server/live/remark_board.h"

#include <algorithm>
#include <utility>

namespace enamel::server {
namespace {

constexpr int64_t kMinuteMs = 60'000;

constexpr auto IsOpen = [](const auto& known) { return known.remark.state != RemarkState::kShown; };
constexpr auto IdOf = [](const auto& known) { return known.remark.id; };

}  // namespace

Status RemarkBoard::Admit(const Uuid& attempt, UnixMs now_ms) const {
  MutexLock lock(mutex_);
  const auto at = sent_.find(attempt);
  if (at == sent_.end()) return Status::Ok();
  const auto waiting = static_cast<size_t>(std::ranges::count_if(at->second, IsOpen));
  if (waiting >= kMaxWaiting) {
    return Status(Code::kConflict, "expected at most " + std::to_string(kMaxWaiting) +
                                       " remarks that the station has not shown yet, there are " +
                                       std::to_string(waiting) + "; wait until it has");
  }
  const auto recent = static_cast<size_t>(std::ranges::count_if(
      at->second, [&](const Known& known) { return now_ms - known.remark.sent_ms < kMinuteMs; }));
  if (recent < kMaxAMinute) return Status::Ok();
  return Status(Code::kUnavailable,
                "expected at most " + std::to_string(kMaxAMinute) +
                    " remarks to one attempt within a minute, there were " +
                    std::to_string(recent) + "; send the next one a little later",
                "throttled");
}

void RemarkBoard::Put(const ChairRemark& remark) {
  MutexLock lock(mutex_);
  auto& sent = sent_[remark.attempt];
  const auto at = std::ranges::lower_bound(sent, remark.id, {}, IdOf);
  if (at == sent.end() || IdOf(*at) != remark.id) {
    sent.insert(at, {remark, remark.state});
  } else {
    at->stored = remark.state;
    if (at->remark.state < remark.state) at->remark = remark;
  }
  if (sent.size() > kMaxKept) sent.pop_front();
  if (sent_.size() > kMaxAttempts) {
    // A search through all of them, only when there is one attempt too many.
    sent_.erase(std::ranges::min_element(
        sent_, {}, [](const auto& entry) { return IdOf(entry.second.back()); }));
  }
  attempts_ = sent_.size();
}

std::vector<protocol::Remark> RemarkBoard::Take(const Uuid& attempt) {
  std::vector<protocol::Remark> out;
  if (attempts_ == 0) return out;
  MutexLock lock(mutex_);
  const auto at = sent_.find(attempt);
  if (at == sent_.end()) return out;
  for (Known& known : at->second) {
    if (!IsOpen(known) || out.size() >= kMaxWaiting) continue;
    ChairRemark& remark = known.remark;
    remark.state = RemarkState::kSent;
    out.push_back({remark.id, remark.text, remark.from, remark.sent_ms});
  }
  return out;
}

void RemarkBoard::Shown(const Uuid& attempt, uint64_t id, UnixMs now_ms) {
  if (id == 0 || attempts_ == 0) return;
  MutexLock lock(mutex_);
  const auto at = sent_.find(attempt);
  if (at == sent_.end()) return;
  for (Known& known : at->second) {
    // One that was never on its way cannot have been shown, whatever the station says.
    if (known.remark.id > id || known.remark.state != RemarkState::kSent) continue;
    known.remark.state = RemarkState::kShown;
    known.remark.shown_ms = now_ms;
  }
}

void RemarkBoard::Remove(const Uuid& attempt) {
  if (attempts_ == 0) return;
  MutexLock lock(mutex_);
  sent_.erase(attempt);
  attempts_ = sent_.size();
}

std::vector<ChairRemark> RemarkBoard::Of(const Uuid& attempt) const {
  std::vector<ChairRemark> out;
  MutexLock lock(mutex_);
  const auto at = sent_.find(attempt);
  if (at == sent_.end()) return out;
  for (const Known& known : at->second) out.push_back(known.remark);
  return out;
}

std::vector<ChairRemark> RemarkBoard::Moved() const {
  std::vector<ChairRemark> out;
  if (attempts_ == 0) return out;
  MutexLock lock(mutex_);
  for (const auto& [attempt, all] : sent_) {
    for (const Known& known : all) {
      if (known.stored < known.remark.state) out.push_back(known.remark);
    }
  }
  return out;
}

void RemarkBoard::Stored(const std::vector<ChairRemark>& moved) {
  MutexLock lock(mutex_);
  for (const ChairRemark& remark : moved) {
    const auto attempt = sent_.find(remark.attempt);
    if (attempt == sent_.end()) continue;
    const auto at = std::ranges::lower_bound(attempt->second, remark.id, {}, IdOf);
    if (at != attempt->second.end() && IdOf(*at) == remark.id) at->stored = remark.state;
  }
}

void RemarkBoard::KeepOnly(const std::set<Uuid>& attempts, UnixMs since_ms) {
  if (attempts_ == 0) return;
  MutexLock lock(mutex_);
  std::erase_if(sent_, [&](const auto& entry) {
    return !attempts.contains(entry.first) && entry.second.back().remark.sent_ms < since_ms;
  });
  attempts_ = sent_.size();
}

}  // namespace enamel::server
