#include "server/app/database_watch.h"

#include <spdlog/spdlog.h>

#include "common/base/stoppable_sleep.h"

namespace enamel::server::app {

DatabaseWatch::DatabaseWatch(Store& store, std::chrono::milliseconds every)
    : store_(store), every_(every), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void DatabaseWatch::Run(const std::stop_token& stop) {
  do {
    // The log already reports an unreachable database; meanwhile the clock keeps its last offset.
    if (store_.look.Look().ok()) Tell(store_.health.Health());
  } while (!SleepUntilStopped(stop, every_));
}

void DatabaseWatch::Tell(const StoreHealth& health) {
  const bool right = health.clock_problem.empty();
  if (clock_right_ && !right) spdlog::error("{}", health.clock_problem);
  if (!clock_right_ && right) spdlog::info("this machine's clock is right again");
  clock_right_ = right;
  if (health.standby == standby_) return;
  if (health.standby == sql::Standby::kSynchronous) {
    spdlog::info("what is committed is on a standby of the database server too");
  } else if (health.standby == sql::Standby::kMissing) {
    spdlog::error(
        "every change waits: the database server acknowledges none until a synchronous standby has "
        "it, and too few are there. See that the standbys that synchronous_standby_names names run "
        "and reach it; or take the setting back, and what was committed last is lost if its disk "
        "is");
  } else if (health.standby == sql::Standby::kUnknown) {
    spdlog::info(
        "this user of the database server is no longer told whether a standby is synchronous; make "
        "it a member of pg_monitor");
  } else if (standby_ == sql::Standby::kSynchronous || standby_ == sql::Standby::kMissing) {
    spdlog::warn(
        "no standby of the database server is synchronous any more: what was committed last is "
        "lost if its disk is");
  }
  standby_ = health.standby;
}

}  // namespace enamel::server::app
