#pragma once

#include <string>

namespace enamel::station {

struct RealtimeRequest {
  int cpu = -1;  // bind the thread to this processor; -1: to none
};

// What the system granted of what a haptic loop asks for. A refusal is no error: the loop runs and
// says so; late ticks are counted either way.
struct RealtimeGrant {
  bool fifo = false;           // SCHED_FIFO priority for the calling thread
  bool memory_locked = false;  // no page of this process is swapped out
  bool pinned = false;         // the thread runs on the processor asked for
  // What was refused, what that means and how to allow it; empty when all was granted.
  std::string refused;
};

// For the calling thread (priority, processor) and the process (memory). Not real-time.
RealtimeGrant RequestRealtime(const RealtimeRequest& request = {});

}  // namespace enamel::station
