#pragma once

#include <string>

namespace enamel::station {

struct RealtimeRequest {
  int cpu = -1;  // bind the thread to this processor; -1: to none
};

// Which of a haptic loop's requests the system granted. A refusal is no error: the loop runs and
// reports it; late ticks are counted either way.
struct RealtimeGrant {
  bool fifo = false;           // SCHED_FIFO priority for the calling thread
  bool memory_locked = false;  // no page of this process is swapped out
  bool pinned = false;         // the thread runs on the requested processor
  // The refused requests, their consequence and how to allow them; empty if all were granted.
  std::string refused;

  // Other programs cannot make ticks late.
  bool steady() const { return fifo && memory_locked; }
};

// Applies to the calling thread (priority, processor) and the process (memory). Not real-time.
RealtimeGrant RequestRealtime(const RealtimeRequest& request = {});

}  // namespace enamel::station
