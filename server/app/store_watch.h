#pragma once

#include <chrono>
#include <stop_token>
#include <thread>

#include "server/storage/engine/database_look.h"
#include "server/storage/store.h"
#include "server/storage/upkeep/store_health.h"

namespace enamel::server::app {

// Asks a database and S3 stores on other machines all the time (DatabaseLook::Beat, Blobs::Look):
// health notices within seconds that one hangs, this process's times stay those of the database's
// clock, and the log reports the start and end of a problem with clock or standby. Two threads of its
// own until destroyed.
class StoreWatch {
 public:
  explicit StoreWatch(Store& store, std::chrono::milliseconds every = DatabaseLook::kEvery);

 private:
  void Run(const std::stop_token& stop);
  void LookAtBuckets(const std::stop_token& stop);
  // What has changed since the last look.
  void Tell(const StoreHealth& health);

  Store& store_;
  const std::chrono::milliseconds every_;
  bool clock_right_ = true;  // on the thread
  // Likewise.
  sql::Standby standby_ = sql::Standby::kUnknown;
  std::jthread thread_, buckets_;  // last: end first
};

}  // namespace enamel::server::app
