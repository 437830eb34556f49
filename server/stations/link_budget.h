#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/mutex.h"
#include "common/base/uuid.h"
#include "server/net/held_bytes.h"
#include "server/ops/budgets.h"
#include "server/training/types.h"

namespace enamel::server::stations {

struct Services;
class Connection;

// Two schools may know a station by the same id: one of them was restored from the other's backup.
using StationOfSchool = std::pair<const Services*, Uuid>;

// What one station may take of the link that all share, so that one whose keys were stolen harms
// itself alone. Of this server: where several share a database, each has a budget of its own. Thread
// safety: any thread.
class LinkBudget {
 public:
  // Frames up to this size are not counted: a chunk has some kB.
  static constexpr size_t kSmallFrameBytes = size_t{64} << 10;
  static constexpr std::chrono::hours kPeriod{24};
  // Requests that the store carries out at once: of the desk, and of what a station sends.
  static constexpr size_t kMaxAtOnce = 2;
  // Time that a station may take before it has to wait: it has just begun, or slept.
  static constexpr std::chrono::milliseconds kTimeAtOnce{500};
  static constexpr std::chrono::milliseconds kLongestRest{500};

  // A chair has one connection for its desk and one for what it sends; a technician's commands
  // beside them take one each. One that records takes a hundredth of a thread's time, one that sends
  // a day's recordings all that it may have. The default of 4 GiB is the largest recording three
  // times over (recording_bounds.h), or a fortnight of ordinary ones that waited at the station.
  explicit LinkBudget(const ops::Budgets& limits = {})
      : limits_(limits), coming_(ops::LimitOf(ops::kStationFrames, limits)) {}
  const ops::Budgets& limits() const { return limits_; }

  // It has said who it is. Returns the oldest of its other connections where it has too many now,
  // for the caller to end; null: none.
  std::shared_ptr<Connection> Enter(const StationOfSchool& station,
                                    const std::shared_ptr<Connection>& connection);
  // Returns the name of a station where work and memory are shared out.
  static std::string PartyOf(const StationOfSchool& station);
  // `of`: PartyOf the station. Null: too much is coming already of this one.
  std::shared_ptr<HeldBytes::Held> Coming(const std::string& of, const void* where, size_t bytes) {
    return coming_.Add(of, where, bytes);
  }
  // A chunk of so many bytes came. False: it is more than fits within kPeriod, and not counted.
  bool Recorded(const StationOfSchool& station, uint64_t bytes, UnixMs now_ms);
  using Clock = std::chrono::steady_clock;
  // The station has taken so much time of a thread. Returns how long its answer has to wait, at most
  // kLongestRest.
  Clock::duration Took(const StationOfSchool& station, Clock::duration time, Clock::time_point now);

  // Returns the use by the stations of one school.
  std::vector<ops::BudgetUse> Uses(const Services* school, UnixMs now_ms) const;

 private:
  struct Party {
    std::deque<std::weak_ptr<Connection>> links{};  // the oldest first
    // Since when these were counted.
    UnixMs since_ms = 0;
    uint64_t recorded_bytes = 0;
    // When all that it took will have been its share (the generic cell rate algorithm, ITU-T
    // I.371).
    Clock::time_point paid_at{};
  };

  const ops::Budgets limits_;
  HeldBytes coming_;
  mutable Mutex mutex_;
  uint64_t too_many_links_ ENAMEL_GUARDED_BY(mutex_) = 0;
  uint64_t too_much_recorded_ ENAMEL_GUARDED_BY(mutex_) = 0;
  uint64_t rests_ ENAMEL_GUARDED_BY(mutex_) = 0;
  std::map<StationOfSchool, Party> parties_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::server::stations
