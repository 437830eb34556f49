#include "server/ops/repeat_log.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/utf8.h"

namespace enamel::server::ops {
namespace {

constexpr size_t kMaxLineBytes = 500;

}  // namespace

RepeatLog::RepeatLog(Say say, Clock clock)
    : say_(say ? std::move(say) : [](const std::string& line) { spdlog::warn("{}", line); }),
      clock_(clock ? std::move(clock) : [] { return std::chrono::steady_clock::now(); }) {}

void RepeatLog::Note(const std::string& key, std::string line) {
  if (line.size() > kMaxLineBytes) line.resize(kMaxLineBytes);
  {
    MutexLock lock(mutex_);
    auto now = clock_();
    auto [at, fresh] = seen_.try_emplace(key);
    Seen& seen = at->second;
    if (!fresh && now - seen.said < kQuiet) {
      ++seen.since;
      return;
    }
    if (seen.since > 0) line += " (and " + std::to_string(seen.since) + " more like it before)";
    seen = {now, 0};
    // One that was forgotten is said again at once: a line too many and never one too few.
    if (seen_.size() > kMaxKeys) ForgetOne();
  }
  say_(Printable(line));
}

void RepeatLog::ForgetOne() {
  seen_.erase(std::min_element(seen_.begin(), seen_.end(), [](const auto& a, const auto& b) {
    return a.second.said < b.second.said;
  }));
}

}  // namespace enamel::server::ops
