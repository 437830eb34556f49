#include "server/app/caretaker.h"

#include <spdlog/spdlog.h>

#include <condition_variable>
#include <mutex>

#include "common/base/counted.h"
#include "common/base/unix_time.h"

namespace enamel::server::app {
namespace {}  // namespace

Caretaker::Caretaker(UpkeepStore& store, Intervals intervals)
    : store_(store),
      intervals_(intervals),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void Caretaker::Run(const std::stop_token& stop) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  // Nobody notifies it. It is a sleep that the stop token ends at once.
  std::condition_variable_any never;
  // What fails is in the log and tried again with the rules.
  (void)store_.FinishErasures();
  auto retention = std::chrono::steady_clock::now() + intervals_.first_retention;
  while (!stop.stop_requested()) {
    LookAtHealth();
    if (std::chrono::steady_clock::now() >= retention) {
      ApplyRetention();
      retention = std::chrono::steady_clock::now() + intervals_.retention;
    }
    never.wait_for(lock, stop, intervals_.health, [] { return false; });
  }
}

void Caretaker::LookAtHealth() {
  StoreHealth health = store_.Health();
  // A write that failed may have been the only one: nobody else may be writing.
  if (!health.takes_recordings && store_.TryWrite().ok()) health = store_.Health();
  if (health.takes_recordings == took_recordings_) return;
  took_recordings_ = health.takes_recordings;
  if (took_recordings_) {
    spdlog::info("recordings are taken again");
  } else {
    spdlog::error("no recordings are taken: {}", health.problem);
  }
}

void Caretaker::ApplyRetention() {
  auto report = store_.ApplyRetention(enamel::UnixMs(), false, Actor{{}, "retention"});
  if (!report.ok()) {
    spdlog::warn("retention rules were not applied, next try in an hour: {}",
                 report.status().message());
    return;
  }
  size_t all = report->unfinished.size() + report->recordings.size() + report->attempts.size();
  if (all + report->blobs == 0) return;
  spdlog::info("retention removed {}, {}, {}, {}",
               Counted(report->unfinished.size(), "unfinished attempt"),
               Counted(report->recordings.size(), "recording"),
               Counted(report->attempts.size(), "attempt"), Counted(report->blobs, "blob"));
}

}  // namespace enamel::server::app
