#pragma once

#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <iostream>
#include <string>

#include "server/storage/verify/verify.h"

namespace enamel::server::app {

// Tells on standard error how far long work is: on a terminal in one line, else a line every ten
// seconds. Work that takes less than a second says nothing.
class ConsoleProgress {
 public:
  ~ConsoleProgress() {
    if (shown_ && terminal_) std::cerr << "\r\033[K" << std::flush;
  }
  void operator()(const std::string& what, uint64_t done, uint64_t all) {
    auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(10'000));
    shown_ = true;
    std::cerr << (terminal_ ? "\r\033[K" : "") << what << ": " << done
              << (all == 0 ? std::string() : " of " + std::to_string(all))
              << (terminal_ ? "" : "\n") << std::flush;
  }

 private:
  const bool terminal_ = ::isatty(STDERR_FILENO) == 1;
  bool shown_ = false;
  std::chrono::steady_clock::time_point next_ =
      std::chrono::steady_clock::now() + std::chrono::seconds(1);
};

inline UpkeepProgress Telling(ConsoleProgress& progress) {
  return [&progress](const std::string& what, uint64_t done, uint64_t all) {
    progress(what, done, all);
  };
}

}  // namespace enamel::server::app
