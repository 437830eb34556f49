#pragma once

#include <string>

#include "server/training/types.h"

namespace enamel::server::app {

// "2026-09-01 08:30", UTC; "-" for 0.
std::string UtcText(UnixMs ms);

}  // namespace enamel::server::app
