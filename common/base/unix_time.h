#pragma once

#include <chrono>
#include <cstdint>

namespace enamel {

// The current time, by the system's clock, which a person may set, until FollowClock. Thread
// safety: any thread.
std::chrono::system_clock::time_point WallClock();

// From now on WallClock is `at` and what goes by from here on the steady clock, whatever becomes of
// the system's. For servers that write into one database, where the times of all are the
// database's.
void FollowClock(std::chrono::system_clock::time_point at);
void FollowSystemClock();  // as at first

// Milliseconds since 1970-01-01 UTC, as documents and messages carry times; without an argument:
// now.
inline int64_t UnixMs(std::chrono::system_clock::time_point t = WallClock()) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(t.time_since_epoch()).count();
}

}  // namespace enamel
