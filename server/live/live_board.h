#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "server/ops/budgets.h"
#include "server/training/types.h"

namespace enamel::server {

// A moment of an attempt being made (station.proto, LiveState; or a tick of a committed chunk).
struct LiveSample {
  Uuid attempt;
  Uuid station;
  uint64_t tick = 0;
  std::array<int32_t, 3> anchor_um{};  // from the device's origin, along the scene's axes
  std::array<int32_t, 3> force_mn{};   // on the operator
  uint32_t flags = 0;                  // witness flags (schemas/trace_format.md, column 19)
  UnixMs received_ms = 0;
};

class LiveWatch;

// Attempts in progress: the latest state wins, nothing is stored. It keeps the newest kMaxRows
// moments of a watched attempt. A watcher fetches those it has not seen when it can, so that a slow
// one misses some and slows nobody down. Watchers that have seen the same share an event's bytes.
//
// Bounded: the latest sample of at most 1024 attempts (the one longest silent is dropped first),
// kMaxRows and one event for each watched attempt, and as many watches as the budgets `views` and
// `person_views` allow. Thread safety: any thread; nothing waits for a watcher.
class LiveBoard {
 public:
  static constexpr uint32_t kRowsPerSecond = 60;
  static constexpr size_t kMaxRows = 60;

  explicit LiveBoard(const ops::Budgets& limits = {}) : limits_(limits) {}

  // Moments of one attempt in order. Ignored unless they end later than the stored ones.
  void Put(std::span<const LiveSample> samples);
  void Put(const LiveSample& sample) { Put(std::span(&sample, 1)); }
  // The attempt is over: its watches end.
  void Remove(const Uuid& attempt);
  std::optional<LiveSample> Latest(const Uuid& attempt) const;
  // Somebody watches it: what Put gets is worth making.
  bool Watched(const Uuid& attempt) const;
  // All that somebody watches and that is not over, with the latest that is known of it.
  std::map<Uuid, std::optional<LiveSample>> WatchedNow() const;
  // None: there are as many as there may be (WhyNot). May outlive the board.
  std::unique_ptr<LiveWatch> Watch(const Uuid& attempt, const Uuid& person);
  // Why this person gets none.
  Status WhyNot(const Uuid& person) const;
  std::vector<ops::BudgetUse> Uses() const;

 private:
  friend class LiveWatch;
  struct Channel {
    size_t watches = 0;
    bool ended = false;
    std::deque<LiveSample> recent;  // oldest first, at most kMaxRows
    // The event made last: of the moments from `first` to `last`.
    uint64_t first = 0, last = 0;
    std::shared_ptr<const std::string> event;
  };
  // Shared with the watches.
  struct State {
    Mutex mutex;
    std::map<Uuid, LiveSample> latest ENAMEL_GUARDED_BY(mutex);
    std::map<Uuid, Channel> channels ENAMEL_GUARDED_BY(mutex);   // the watched attempts
    std::map<Uuid, size_t> watches_of ENAMEL_GUARDED_BY(mutex);  // by person
    std::atomic<size_t> watches{0};                              // changed under mutex
    uint64_t refused ENAMEL_GUARDED_BY(mutex) = 0;
    uint64_t refused_of_person ENAMEL_GUARDED_BY(mutex) = 0;
  };

  const ops::Budgets limits_;
  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

// One watcher of one attempt. Thread safety: one thread at a time.
class LiveWatch {
 public:
  LiveWatch(std::shared_ptr<LiveBoard::State> state, const Uuid& attempt, const Uuid& person)
      : state_(std::move(state)), attempt_(attempt), person_(person) {}
  ~LiveWatch();
  LiveWatch(const LiveWatch&) = delete;
  LiveWatch& operator=(const LiveWatch&) = delete;

  // What came since the last call, the newest kMaxRows only: {"tick":…,"rows":[[tick, anchor x, y,
  // z in um, force x, y, z in mN, flags],…]} (schemas/api/openapi.yaml, LiveEvent). Null: nothing
  // new.
  std::shared_ptr<const std::string> Next();
  // The attempt was sealed.
  bool ended() const { return ended_; }

 private:
  const std::shared_ptr<LiveBoard::State> state_;
  const Uuid attempt_, person_;
  std::optional<uint64_t> seen_;  // newest tick
  bool ended_ = false;
};

}  // namespace enamel::server
