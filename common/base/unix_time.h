#pragma once

#include <chrono>
#include <cstdint>

namespace enamel {

// The current time, by the system's clock, which a person may set, until FollowClock. Thread
// safety: any thread.
std::chrono::system_clock::time_point WallClock();

// From now on WallClock starts at `at` and follows the steady clock, whatever happens to the
// system's clock. For servers that write into one database, where all times are the database's.
void FollowClock(std::chrono::system_clock::time_point at);
void FollowSystemClock();  // as at first

// Milliseconds since 1970-01-01 UTC, the form of times in documents and messages; without an
// argument: the current time.
inline int64_t UnixMs(std::chrono::system_clock::time_point t = WallClock()) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(t.time_since_epoch()).count();
}

}  // namespace enamel
