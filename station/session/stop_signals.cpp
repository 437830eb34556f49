#include "station/session/stop_signals.h"

#include <csignal>

namespace enamel::station {
namespace {

// Lock-free, so that a handler may add to it.
std::atomic<int> stops_asked{0};
static_assert(std::atomic<int>::is_always_lock_free);

void OnStop(int) { ++stops_asked; }

}  // namespace

void CatchStopSignals() {
  struct sigaction hang_up {};
  const bool keeps_on =
      ::sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler == SIG_IGN;
  for (const int signal : {SIGINT, SIGQUIT, SIGTERM, SIGHUP, SIGTSTP}) {
    if (signal != SIGHUP || !keeps_on) std::signal(signal, OnStop);
  }
  for (const int signal : {SIGTTIN, SIGTTOU}) std::signal(signal, SIG_IGN);
}

const std::atomic<int>& StopsAsked() { return stops_asked; }

}  // namespace enamel::station
