#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "common/trace/keyframes.h"
#include "common/trace/trace.h"
#include "station/session/prepared_attempt.h"

namespace enamel::station {

// A stretch of a recording: the core as it stood before its first tick, and its ticks.
struct Stretch {
  std::unique_ptr<core::Core> core;
  std::vector<trace::Tick> ticks;
  // Time that had passed before the first of them, gaps included.
  uint64_t passed_ticks = 0;
};

// A recording on this station, computed again to any moment of it. Keeps keyframes in memory, so
// that a second moment takes less time. Not real-time. Thread safety: one thread at a time.
class LookBack {
 public:
  // `prepared`: its documents and its own header; no core.
  LookBack(PreparedAttempt prepared, trace::TraceFile file);

  const PreparedAttempt& prepared() const { return prepared_; }
  // The ticks from `from` to before `to`, counted from 0 without gaps; beyond the last: as many as
  // there are, and none where `from` is. Errors: kConflict when it does not compute to what was
  // recorded; trace::ReplayToMoment's.
  Result<Stretch> Take(uint64_t from, uint64_t to,
                       const std::function<bool(double progress)>& keep_going = {});

 private:
  const PreparedAttempt prepared_;
  const trace::TraceFile file_;
  trace::Keyframes keyframes_;
};

}  // namespace enamel::station
