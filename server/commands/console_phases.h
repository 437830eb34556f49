#pragma once

#include <condition_variable>
#include <string>
#include <thread>

#include "common/base/mutex.h"

namespace enamel::server::app {

// Says on standard error what long work does: a line when a phase begins and, on a terminal, another
// every five seconds until it ends. Nothing where the log is JSON. Begin on one thread.
class ConsolePhases {
 public:
  ConsolePhases();

  void Begin(const std::string& phase);

 private:
  void Repeat(const std::stop_token& stop);

  Mutex mutex_;
  std::condition_variable_any wake_;
  std::string phase_ ENAMEL_GUARDED_BY(mutex_);
  int seconds_ ENAMEL_GUARDED_BY(mutex_) = 0;  // that it has taken, as last said
  std::jthread thread_;                        // on a terminal; the first to go
};

}  // namespace enamel::server::app
