#include "server/app/store_watch.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/stoppable_sleep.h"
#include "server/storage/blobs/s3_trouble.h"
#include "server/storage/store_engine.h"

namespace enamel::server::app {

// A database that has failed may be another's since: a standby takes over within a second.
constexpr std::chrono::milliseconds kRepeat{250};

StoreWatch::StoreWatch(Store& store, std::chrono::milliseconds every)
    : store_(store), every_(every) {
  // What is in a folder on this machine shows its state by itself.
  if (!store.shared) return;
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  buckets_ = std::jthread([this](const std::stop_token& stop) { LookAtBuckets(stop); });
}

void StoreWatch::LookAtBuckets(const std::stop_token& stop) {
  do {
    store_.engine->blobs->Look();
    store_.engine->keyring->Look();
  } while (!SleepUntilStopped(stop, std::chrono::milliseconds(S3Trouble::kLookEveryMs / 2)));
}

void StoreWatch::Run(const std::stop_token& stop) {
  bool beaten = false;
  do {
    // The log already reports an unreachable database; meanwhile the clock keeps its last offset.
    beaten = store_.look.Beat().ok();
    if (beaten) Tell(store_.health.Health());
  } while (!SleepUntilStopped(stop, beaten ? every_ : std::min(every_, kRepeat)));
}

void StoreWatch::Tell(const StoreHealth& health) {
  const bool right = health.clock_problem.empty();
  if (clock_right_ && !right) spdlog::error("{}", health.clock_problem);
  if (!clock_right_ && right)
    spdlog::info("the clocks of this machine and the database agree again");
  clock_right_ = right;
  if (health.standby == standby_) return;
  if (health.standby == sql::Standby::kSynchronous) {
    spdlog::info("commits are on a standby of the database server too");
  } else if (health.standby == sql::Standby::kMissing) {
    spdlog::error(
        "every change waits: the database server acknowledges none until a synchronous standby has "
        "it, and too few are connected. Check that the standbys in synchronous_standby_names run "
        "and can reach it. Or remove the setting: the last commits are then lost if its disk "
        "fails");
  } else if (health.standby == sql::Standby::kUnknown) {
    spdlog::info(
        "the database server no longer shows this user whether a standby is synchronous; make the "
        "user a member of pg_monitor");
  } else if (standby_ == sql::Standby::kSynchronous || standby_ == sql::Standby::kMissing) {
    spdlog::warn(
        "no standby of the database server is synchronous any more: the last commits are lost if "
        "its disk fails");
  }
  standby_ = health.standby;
}

}  // namespace enamel::server::app
