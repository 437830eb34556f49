#pragma once

#include <chrono>
#include <cstdint>

namespace enamel {

// Milliseconds since 1970-01-01 UTC, as documents and messages carry times; without an argument:
// now, by the system's clock, which somebody may set.
inline int64_t UnixMs(std::chrono::system_clock::time_point t = std::chrono::system_clock::now()) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(t.time_since_epoch()).count();
}

}  // namespace enamel
