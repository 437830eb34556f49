#pragma once

#include <array>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "server/training/types.h"

namespace enamel::server {

// A decimated picture of an attempt being made (station.proto, LiveState).
struct LiveSample {
  Uuid attempt;
  Uuid station;
  uint64_t tick = 0;
  std::array<int32_t, 3> anchor_um{};
  std::array<int32_t, 3> force_mn{};
  uint32_t flags = 0;
  UnixMs received_ms = 0;
};

// The latest sample of every attempt that is being watched or could be: latest wins, nothing is
// queued, nothing is stored. Bounded: at most 1024 attempts, the one longest silent goes first.
// Thread safety: any thread.
class LiveBoard {
 public:
  // Ignored when an equal or later tick is there already.
  void Put(const LiveSample& sample);
  void Remove(const Uuid& attempt);
  std::optional<LiveSample> Latest(const Uuid& attempt) const;
  std::vector<LiveSample> All() const;

 private:
  mutable std::mutex mutex_;
  std::map<Uuid, LiveSample> latest_;  // guarded by mutex_
};

}  // namespace enamel::server
