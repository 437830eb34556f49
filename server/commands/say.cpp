#include "server/commands/say.h"

#include <spdlog/fmt/chrono.h>

#include <ctime>

namespace enamel::server::app {

std::string UtcText(UnixMs ms) {
  if (ms == 0) return "-";
  return fmt::format("{:%Y-%m-%d %H:%M}", fmt::gmtime(static_cast<std::time_t>(ms / 1000)));
}

}  // namespace enamel::server::app
