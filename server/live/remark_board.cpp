#include "server/live/remark_board.h"

#include <algorithm>
#include <utility>

namespace enamel::server {
namespace {

constexpr int64_t kMinuteMs = 60'000;

bool IsOpen(const SentRemark& sent) { return sent.state != RemarkState::kShown; }

}  // namespace

Status RemarkBoard::Admit(const Uuid& attempt, UnixMs now_ms) const {
  MutexLock lock(mutex_);
  const auto at = sent_.find(attempt);
  if (at == sent_.end()) return Status::Ok();
  const auto waiting = static_cast<size_t>(std::ranges::count_if(at->second, IsOpen));
  if (waiting >= kMostWaiting) {
    return Status(Code::kConflict, "expected at most " + std::to_string(kMostWaiting) +
                                       " remarks that the station has not shown yet, there are " +
                                       std::to_string(waiting) + "; wait until it has");
  }
  const auto recent =
      static_cast<size_t>(std::ranges::count_if(at->second, [&](const SentRemark& sent) {
        return now_ms - sent.remark.sent_unix_ms < kMinuteMs;
      }));
  if (recent < kMostAMinute) return Status::Ok();
  return Status(Code::kUnavailable,
                "expected at most " + std::to_string(kMostAMinute) +
                    " remarks to one attempt within a minute, there were " +
                    std::to_string(recent) + "; send the next one a little later",
                "throttled");
}

SentRemark RemarkBoard::Send(const Uuid& attempt, std::string text, std::string from, uint64_t tick,
                             UnixMs now_ms) {
  MutexLock lock(mutex_);
  auto& sent = sent_[attempt];
  // Time, so that one sent after a restart of the server is not taken for one shown before it.
  auto id = static_cast<uint64_t>(std::max<UnixMs>(now_ms, 1));
  if (!sent.empty()) id = std::max(id, sent.back().remark.id + 1);
  sent.push_back({{id, std::move(text), std::move(from), now_ms}, tick, RemarkState::kWaiting, 0});
  const SentRemark out = sent.back();
  if (sent.size() > kMostKept) sent.pop_front();
  if (sent_.size() > kMostAttempts) {
    // A search through all of them, only when there is one attempt too many.
    sent_.erase(std::ranges::min_element(
        sent_, {}, [](const auto& entry) { return entry.second.back().remark.id; }));
  }
  attempts_ = sent_.size();
  return out;
}

std::vector<protocol::Remark> RemarkBoard::Take(const Uuid& attempt) {
  std::vector<protocol::Remark> out;
  if (attempts_ == 0) return out;
  MutexLock lock(mutex_);
  const auto at = sent_.find(attempt);
  if (at == sent_.end()) return out;
  for (SentRemark& sent : at->second) {
    if (!IsOpen(sent) || out.size() >= kMostWaiting) continue;
    sent.state = RemarkState::kSent;
    out.push_back(sent.remark);
  }
  return out;
}

void RemarkBoard::Shown(const Uuid& attempt, uint64_t id, UnixMs now_ms) {
  if (id == 0 || attempts_ == 0) return;
  MutexLock lock(mutex_);
  const auto at = sent_.find(attempt);
  if (at == sent_.end()) return;
  for (SentRemark& sent : at->second) {
    // One that was never on its way cannot have been shown, whatever the station says.
    if (sent.remark.id > id || sent.state != RemarkState::kSent) continue;
    sent.state = RemarkState::kShown;
    sent.shown_ms = now_ms;
  }
}

void RemarkBoard::Remove(const Uuid& attempt) {
  if (attempts_ == 0) return;
  MutexLock lock(mutex_);
  sent_.erase(attempt);
  attempts_ = sent_.size();
}

std::vector<SentRemark> RemarkBoard::Of(const Uuid& attempt) const {
  MutexLock lock(mutex_);
  const auto at = sent_.find(attempt);
  if (at == sent_.end()) return {};
  return {at->second.begin(), at->second.end()};
}

}  // namespace enamel::server
