#include "server/commands/say.h"

#include <spdlog/fmt/chrono.h>

#include <ctime>

namespace enamel::server::app {

std::string WithPlainLineEnds(std::string csv) {
  for (size_t at = 0; (at = csv.find("\r\n", at)) != std::string::npos;) csv.erase(at, 1);
  return csv;
}

const char* StateText(AttemptState state) {
  switch (state) {
    case AttemptState::kTicketed:
      return "not started";
    case AttemptState::kRecording:
      return "recording";
    case AttemptState::kSealed:
      return "waiting to be scored";
    case AttemptState::kScoring:
      return "being scored";
    case AttemptState::kScored:
      return "scored";
    case AttemptState::kFailed:
      return "scoring failed";
    case AttemptState::kQuarantined:
      return "set aside";
  }
  return "";
}

std::string UtcText(UnixMs ms) {
  if (ms == 0) return "-";
  return fmt::format("{:%Y-%m-%d %H:%M}", fmt::gmtime(static_cast<std::time_t>(ms / 1000)));
}

}  // namespace enamel::server::app
