#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stop_token>

#include "common/base/mutex.h"

namespace enamel {

// Sleeps for `time`, or until `stop` is requested. Returns whether it was. Thread safety: any
// thread.
inline bool SleepUntilStopped(const std::stop_token& stop, std::chrono::nanoseconds time) {
  Mutex mutex;
  std::unique_lock lock(mutex);
  // Nobody notifies it but the stop token.
  std::condition_variable_any never;
  never.wait_for(lock, stop, time, [] { return false; });
  return stop.stop_requested();
}

}  // namespace enamel
