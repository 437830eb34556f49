#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <optional>
#include <stop_token>
#include <thread>

#include "server/storage/store.h"

namespace enamel::server::app {

// Looks after the store while the server runs: says in the log when it stops taking recordings and
// when it takes them again, counts the jobs, looks for the newest backup, finishes erasures that were left, and applies
// the retention rules now and then. A thread of its own until destroyed.
class Caretaker {
 public:
  struct Intervals {
    std::chrono::milliseconds health{1000};
    std::chrono::milliseconds jobs{10 * 1000};
    std::chrono::milliseconds first_retention{10 * 60 * 1000};  // after the start
    std::chrono::milliseconds retention{60 * 60 * 1000};        // and erasures that were left
    std::chrono::milliseconds held{35 * 1000};  // erasures, while another server is at it
  };
  explicit Caretaker(Store& store) : Caretaker(store, Intervals()) {}
  Caretaker(Store& store, Intervals intervals);

  static constexpr std::array<const char*, 3> kJobStates{"queued", "running", "failed"};
  // As last counted, up to 200 of a state; none: not yet. Any thread, without waiting.
  std::optional<size_t> jobs(size_t state) const;
  // When the newest backup was made, as last looked; 0: none, or not looked yet. Any thread,
  // without waiting.
  int64_t newest_backup_ms() const { return newest_backup_ms_; }

 private:
  void Run(const std::stop_token& stop);
  void LookAtHealth();
  void CountJobs();
  void LookAtBackups();
  void ApplyRetention();

  Store& store_;
  const Intervals intervals_;
  bool took_recordings_ = true;  // on the thread
  std::array<std::atomic<int>, kJobStates.size()> jobs_{-1, -1, -1};
  std::atomic<int64_t> newest_backup_ms_{0};
  std::jthread thread_;  // last: ends first
};

}  // namespace enamel::server::app
