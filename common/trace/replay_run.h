#pragma once

#include <functional>

#include "common/trace/replay.h"
#include "common/trace/trace.h"

namespace enamel::trace {

using TickObserver = std::function<void(const Tick&, const core::TickOutput&)>;

// One pass over a recording's chunks: chain, witness, state hashes. Replay (replay.h) and
// ReplayToMoment (moment.h) share it.
class ReplayRun {
 public:
  // `core` has the header's parameters. It has not stepped, or StartAt gives its state.
  ReplayRun(core::Core& core, const Header& header);
  // The core is not one to replay this recording with.
  Status CheckCore() const;

  // Takes a chunk's place in the chain without re-running it. Errors: undecodable head, broken
  // chain.
  Status Skip(const Bytes& bytes);
  // After Skip: the core was restored to the chain's current place.
  void StartAt(uint64_t gap_ticks);
  // Re-runs a chunk, but no further than `until_tick` ticks in all. Errors: undecodable, broken
  // chain.
  Status Run(const Bytes& bytes, uint64_t until_tick, const TickObserver& observe = {});

  // kUnavailable when `keep_going` (may be empty), asked with the share of chunks done, says no.
  Status CheckKeepGoing(const std::function<bool(double)>& keep_going, size_t chunks) const;

  const ChainState& chain() const { return chain_.state(); }
  ReplayReport& report() { return report_; }

 private:
  template <typename Decoded>
  Status Accept(const Decoded& chunk);
  void NoteFirst(uint64_t tick, const char* what);

  core::Core& core_;
  const Header& header_;
  ChainVerifier chain_;
  ReplayReport report_;
};

}  // namespace enamel::trace
