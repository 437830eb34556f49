#include "server/stations/refusal_log.h"

#include <spdlog/spdlog.h>

#include <algorithm>

namespace enamel::server::stations {
namespace {

// Names and reasons hold what a peer wrote; a line of the log stays one line.
std::string Printable(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

std::string Named(const std::string& peer, const std::string& station) {
  return station.empty() ? "a peer at " + peer : "station \"" + station + "\" at " + peer;
}

}  // namespace

RefusalLog::RefusalLog(Say say, Clock clock)
    : say_(say ? std::move(say) : [](const std::string& line) { spdlog::warn("{}", line); }),
      clock_(clock ? std::move(clock) : [] { return std::chrono::steady_clock::now(); }) {}

void RefusalLog::Note(const std::string& peer, const std::string& station,
                      const wire::Error& error) {
  std::string who = Named(peer, station);
  std::string line;
  {
    std::lock_guard lock(mutex_);
    auto now = clock_();
    auto [at, fresh] = seen_.try_emplace(who + "\n" + error.code() + "\n" + error.field());
    Seen& seen = at->second;
    if (!fresh && now - seen.said < kQuiet) {
      ++seen.since;
      return;
    }
    line = "station link: refused " + who + ": " + error.code() + ": " + error.message();
    if (seen.since > 0) line += " (and " + std::to_string(seen.since) + " more like it before)";
    seen = {now, 0};
    if (seen_.size() > kMaxPeers) ForgetOne();
  }
  say_(Printable(std::move(line)));
}

void RefusalLog::ForgetOne() {
  seen_.erase(std::min_element(seen_.begin(), seen_.end(), [](const auto& a, const auto& b) {
    return a.second.said < b.second.said;
  }));
}

}  // namespace enamel::server::stations
