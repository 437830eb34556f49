#include "server/ops/refusal_log.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/utf8.h"

namespace enamel::server::ops {
namespace {

constexpr size_t kMaxLineBytes = 500;

}  // namespace

RefusalLog::RefusalLog(std::string door, Say say, Clock clock)
    : door_(std::move(door)),
      say_(say ? std::move(say) : [](const std::string& line) { spdlog::warn("{}", line); }),
      clock_(clock ? std::move(clock) : [] { return std::chrono::steady_clock::now(); }) {}

void RefusalLog::Note(const Refusal& refusal) {
  std::string line;
  {
    MutexLock lock(mutex_);
    auto now = clock_();
    auto [at, fresh] = seen_.try_emplace(refusal.who + "\n" + refusal.kind);
    Seen& seen = at->second;
    if (!fresh && now - seen.said < kQuiet) {
      ++seen.since;
      return;
    }
    line = door_ + ": refused " + refusal.who + ": " + refusal.reason;
    if (seen.since > 0) line += " (and " + std::to_string(seen.since) + " more like it before)";
    seen = {now, 0};
    // A peer that was forgotten is said again at once: a line too many and never one too few.
    if (seen_.size() > kMaxPeers) ForgetOne();
  }
  // Names and reasons may hold a peer's text; a line of the log stays one line.
  if (line.size() > kMaxLineBytes) line.resize(kMaxLineBytes);
  say_(Printable(line));
}

void RefusalLog::ForgetOne() {
  seen_.erase(std::min_element(seen_.begin(), seen_.end(), [](const auto& a, const auto& b) {
    return a.second.said < b.second.said;
  }));
}

}  // namespace enamel::server::ops
