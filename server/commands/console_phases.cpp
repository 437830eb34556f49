#include "server/commands/console_phases.h"

#include <unistd.h>

#include <chrono>
#include <iostream>

#include "common/program/log.h"

namespace enamel::server::app {
namespace {

constexpr std::chrono::seconds kEvery{5};

}  // namespace

ConsolePhases::ConsolePhases() {
  if (program::LogIsJson() || ::isatty(STDERR_FILENO) == 0) return;
  thread_ = std::jthread([this](const std::stop_token& stop) { Repeat(stop); });
}

void ConsolePhases::Begin(const std::string& phase) {
  if (program::LogIsJson()) return;
  const MutexLock lock(mutex_);
  phase_ = phase;
  seconds_ = 0;
  std::cerr << phase << '\n';
  wake_.notify_all();
}

void ConsolePhases::Repeat(const std::stop_token& stop) {
  const MutexLock lock(mutex_);
  while (!stop.stop_requested()) {
    const std::string phase = phase_;
    // Woken by the next phase, too: its first five seconds begin then.
    wake_.wait_for(mutex_, stop, kEvery, [&]() ENAMEL_REQUIRES(mutex_) { return phase_ != phase; });
    if (stop.stop_requested() || phase_ != phase || phase.empty()) continue;
    seconds_ += static_cast<int>(kEvery.count());
    std::cerr << phase << ", " << seconds_ << " s\n";
  }
}

}  // namespace enamel::server::app
