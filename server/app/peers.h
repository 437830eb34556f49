#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/base/mutex.h"
#include "common/base/sha256.h"
#include "common/protocol/messages.h"
#include "server/storage/store.h"
#include "server/storage/upkeep/readiness.h"

namespace enamel::server::app {

// Whether the other servers of the school have the same trouble as this one. While it has none,
// nobody is asked. Otherwise each server whose heartbeat row was new when this one last read the rows
// is asked every second what it has measured (Measure, schemas/wire/README.md), not what it makes of
// that. A thread of its own until destroyed. Thread safety: any thread.
class Peers {
 public:
  // `certificate`: the servers' common one. `every`: for tests.
  Peers(Store& store, const Sha256& certificate,
        std::chrono::milliseconds every = std::chrono::seconds(1));

  // As last found; none: this server has no trouble, or the others have not been asked yet.
  std::optional<PeersView> view() const;

 private:
  void Run(const std::stop_token& stop);
  PeersView Ask(const std::vector<DatabaseLook::Peer>& peers);
  void Tell(const StoreHealth& health, const PeersView& view);
  std::optional<wire::Measured> Ask(const DatabaseLook::Peer& peer) const;

  Store& store_;
  const Sha256 certificate_;
  const std::chrono::milliseconds every_;
  mutable Mutex mutex_;
  std::optional<PeersView> view_ ENAMEL_GUARDED_BY(mutex_);
  // The thread's: since when this server has each trouble, and what the log says of it.
  std::optional<std::chrono::steady_clock::time_point> database_, buckets_;
  std::string told_;
  std::jthread thread_;  // last: ends first
};

// What this server tells the others. Does not wait for the database.
wire::Measured MeasuredBy(Store& store);

}  // namespace enamel::server::app
