#include "server/app/caretaker.h"

#include <spdlog/spdlog.h>

#include "common/base/counted.h"
#include "common/base/stoppable_sleep.h"
#include "common/base/unix_time.h"
#include "server/jobs/backup_run.h"

namespace enamel::server::app {

Caretaker::Caretaker(Store& store, Intervals intervals)
    : store_(store),
      intervals_(intervals),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void Caretaker::Run(const std::stop_token& stop) {
  auto erasures = std::chrono::steady_clock::now();
  auto jobs = erasures;
  auto retention = erasures + intervals_.first_retention;
  do {
    LookAtHealth();
    const auto now = std::chrono::steady_clock::now();
    if (now >= jobs) {
      CountJobs();
      LookAtBackups();
      jobs = now + intervals_.jobs;
    }
    if (now >= erasures) {
      // What fails is in the log. A lease may be that of a server that died, or of this one before
      // it did.
      const bool held = store_.erasures.FinishErasures().field() == kLeaseHeld;
      erasures = now + (held ? intervals_.held : intervals_.retention);
    }
    if (now >= retention) {
      ApplyRetention();
      retention = now + intervals_.retention;
    }
  } while (!SleepUntilStopped(stop, intervals_.health));
}

void Caretaker::LookAtHealth() {
  StoreHealth health = store_.health.Health();
  // A write that failed may have been the only one: nobody else may be writing.
  if (!health.takes_recordings && store_.health.TryWrite().ok()) health = store_.health.Health();
  if (health.takes_recordings == took_recordings_) return;
  took_recordings_ = health.takes_recordings;
  if (took_recordings_) {
    spdlog::info("recordings are taken again");
  } else {
    spdlog::error("no recordings are taken: {}", health.problem);
  }
}

// Lists at most 200 of a state. An operator has to know that they pile up, not how high.
void Caretaker::CountJobs() {
  for (size_t i = 0; i < kJobStates.size(); ++i) {
    if (auto found = store_.jobs.Jobs(kJobStates[i]); found.ok()) {
      jobs_[i] = static_cast<int>(found->size());
    }
  }
}

void Caretaker::LookAtBackups() {
  if (const auto newest = store_.audit.NewestOf(kBackupMade); newest.ok() && *newest)
    newest_backup_ms_ = (*newest)->at_ms;
}

std::optional<size_t> Caretaker::jobs(size_t state) const {
  const int count = jobs_[state];
  return count < 0 ? std::nullopt : std::optional<size_t>(count);
}

void Caretaker::ApplyRetention() {
  auto report = store_.retention.ApplyRetention(enamel::UnixMs(), false, Actor{{}, "retention"});
  // It keeps to the same rules.
  if (report.status().field() == kLeaseHeld) return;
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
