#include "server/app/stop_signals.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <utility>

#include "common/base/stoppable_sleep.h"

namespace enamel::server::app {
namespace {

constexpr auto kFurtherSignalsIgnored = std::chrono::seconds(2);

}  // namespace

StopSignals::StopSignals(boost::asio::io_context& io) : signals_(io, SIGINT, SIGTERM) {}

void StopSignals::OnFirst(std::function<void()> stop) {
  signals_.async_wait([this, stop = std::move(stop)](const boost::system::error_code&, int signal) {
    spdlog::info("signal {}: finishing what is in progress", signal);
    // A thread and no timer of `io`: the loop may be what hangs, and the next signal must then get
    // through.
    patience_ = std::jthread([this](const std::stop_token& ended) { EndPatience(ended); });
    stop();
  });
}

void StopSignals::EndSoon(std::chrono::milliseconds longest) {
  last_ = std::jthread([this, longest](const std::stop_token& ended) {
    if (SleepUntilStopped(ended, longest)) return;
    const bool only_jobs = only_jobs_;
    if (only_jobs) {
      spdlog::warn(
          "stopping in the middle of a job: it begins again after the next start, nothing is lost");
    } else {
      spdlog::error(
          "stopping without waiting longer: changes that were not answered are in doubt. Stations "
          "send theirs again; check on the page before you repeat one");
    }
    spdlog::default_logger()->flush();
    std::_Exit(only_jobs ? 0 : 1);
  });
}

void StopSignals::EndPatience(const std::stop_token& ended) {
  const bool is_over = SleepUntilStopped(ended, kFurtherSignalsIgnored);
  // Without a handler SIGINT and SIGTERM end the process, as somebody who presses again wants.
  if (!is_over) signals_.clear();
}

}  // namespace enamel::server::app
