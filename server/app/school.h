#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "server/app/caretaker.h"
#include "server/app/data_folder.h"
#include "server/auth/authenticator.h"
#include "server/jobs/worker.h"
#include "server/live/board_keeper.h"
#include "server/live/live_board.h"
#include "server/live/live_follower.h"
#include "server/live/station_board.h"
#include "server/ops/metrics.h"
#include "server/stations/content.h"
#include "server/stations/session.h"
#include "server/storage/store.h"

namespace enamel::server::app {

struct SchoolOptions {
  auth::AuthOptions auth{};
  int job_threads = 1;  // 0: no attempt is scored here
  ops::Budgets budgets{};
};

// One school as a server serves it, without its ports: its store, access rights, live state, and
// the threads that score its attempts and maintain it.
//
// Thread safety: Start and StopJobs once each, from one thread; the objects it returns may be used
// from any thread. Destruction waits for the threads.
class School {
 public:
  // `store`: of its data folder.
  School(std::unique_ptr<Store> store, const ServerIdentity& identity,
         const SchoolOptions& options);
  School(const School&) = delete;
  School& operator=(const School&) = delete;

  // From now on people and stations may connect.
  void Start();
  // An interrupted job begins again after the next start.
  void StopJobs() { worker_.Stop(); }
  // Stops serving it: streams end, nothing is scored, and nobody waits for another process's work.
  // Running requests finish. The maintenance threads end with it.
  void End();
  // Request::school_ended.
  const std::atomic<bool>& ended() const { return ended_; }

  Store& store() { return *store_; }
  auth::Authenticator& authenticator() { return authenticator_; }
  LiveBoard& live() { return live_; }
  StationBoard& stations() { return stations_; }
  stations::Services& services() { return services_; }
  // Of the process, the store and the stations.
  ops::Metrics& metrics() { return metrics_; }

 private:
  std::atomic<bool> ended_{false};
  // In this order: later members use earlier ones.
  const std::unique_ptr<Store> store_;
  auth::Authenticator authenticator_;
  LiveBoard live_;
  StationBoard stations_;
  stations::Content content_;
  stations::Services services_;
  ops::Metrics metrics_;
  Worker worker_;
  std::optional<Caretaker> caretaker_;
  std::optional<BoardKeeper> keeper_;
  std::optional<LiveFollower> follower_;
};

}  // namespace enamel::server::app
