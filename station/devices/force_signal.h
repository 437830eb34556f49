#pragma once

#include <semaphore.h>
#include <time.h>

#include <atomic>
#include <cstdint>

#include "common/base/check.h"

namespace enamel::station {

// Wakes the thread that writes forces to a bus. However often the tick posts before that thread looks, it
// wakes once: a bus that blocks leaves no queue behind. Thread safety: Post by one thread, Wait by
// another. Real-time: Post is safe.
class ForceSignal {
 public:
  ForceSignal() { ENAMEL_CHECK(sem_init(&posted_, 0, 0) == 0); }
  ~ForceSignal() { sem_destroy(&posted_); }
  ForceSignal(const ForceSignal&) = delete;
  ForceSignal& operator=(const ForceSignal&) = delete;

  ENAMEL_REALTIME void Post() noexcept {
    if (!waits_.exchange(true, std::memory_order_acq_rel)) sem_post(&posted_);
  }
  // Until a post or the time is over. Read the force afterwards.
  void Wait(int64_t timeout_us) noexcept {
    timespec until{};
    clock_gettime(CLOCK_MONOTONIC, &until);
    const int64_t ns = until.tv_nsec + timeout_us * 1000;
    until.tv_sec += ns / kSecond_ns;
    until.tv_nsec = ns % kSecond_ns;
    sem_clockwait(&posted_, CLOCK_MONOTONIC, &until);
    // Before the force is read: a force that arrives in between posts again, so none is missed.
    waits_.store(false, std::memory_order_release);
  }

 private:
  static constexpr int64_t kSecond_ns = 1'000'000'000;
  std::atomic<bool> waits_{false};
  sem_t posted_;
};

}  // namespace enamel::station
