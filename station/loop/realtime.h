#pragma once

#include <string>

namespace enamel::station {

// What the system granted of what a haptic loop asks for. A refusal is no error: the loop runs and
// says so; late ticks are counted either way.
struct RealtimeGrant {
  bool fifo = false;           // SCHED_FIFO priority for the calling thread
  bool memory_locked = false;  // no page of this process is swapped out
  std::string refused;         // what was refused and how to allow it; empty when all was granted
};

// For the calling thread (priority) and the process (memory). Not real-time.
RealtimeGrant RequestRealtime();

}  // namespace enamel::station
