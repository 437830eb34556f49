#pragma once

#include <chrono>
#include <stop_token>
#include <thread>

#include "server/storage/store.h"

namespace enamel::server::app {

// Looks after the store while the server runs: says in the log when it stops taking recordings and
// when it takes them again, finishes erasures that were left, and applies the retention rules now
// and then. A thread of its own until destroyed.
class Caretaker {
 public:
  struct Intervals {
    std::chrono::milliseconds health{1000};
    std::chrono::milliseconds first_retention{10 * 60 * 1000};  // after the start
    std::chrono::milliseconds retention{60 * 60 * 1000};        // and erasures that were left
    std::chrono::milliseconds held{35 * 1000};  // erasures, while another server is at it
  };
  explicit Caretaker(Store& store) : Caretaker(store, Intervals()) {}
  Caretaker(Store& store, Intervals intervals);

 private:
  void Run(const std::stop_token& stop);
  void LookAtHealth();
  void ApplyRetention();

  Store& store_;
  const Intervals intervals_;
  bool took_recordings_ = true;  // on the thread
  std::jthread thread_;          // last: ends first
};

}  // namespace enamel::server::app
