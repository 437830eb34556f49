#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "common/trace/keyframes.h"
#include "common/trace/replay.h"

namespace enamel::trace {

// How to reach a moment of a recording.
struct MomentOptions {
  // Ticks stepped when it is reached; beyond the last one: all of them.
  uint64_t to_tick = UINT64_MAX;
  // False: from the first tick, as for verification; keyframes are then only made.
  bool start_from_keyframe = true;
  // The replay saves a keyframe at the end of the first chunk after this much computing, so that
  // any moment is at most about this far from one, whatever the voxel size. 0: after every chunk.
  double keyframe_every_s = 0.25;
};

// A core at a moment, and how it got there.
struct Moment {
  std::unique_ptr<core::Core> core;
  // Witness and state hashes of what was re-run; `ticks`, `chunks` and `gap_ticks` count from the
  // first tick, `seconds` is all of the time taken.
  ReplayReport report;
  uint64_t from_tick = 0;  // 0, or the keyframe's
  bool whole = false;      // the recording's last tick is reached
  std::string discarded;   // why the keyframes were thrown away; empty when they were not
};

// Re-runs a recording up to a moment, from the last keyframe that leaves at least one whole chunk
// to compare, and adds keyframes on the way while the witness agrees. Keyframes that are not on the
// chain, cannot be restored, or are followed by a disagreement are dropped from `keyframes`, and
// the replay starts at tick 0. The chain is also checked over the chunks that are not re-run.
// `make_core` gives a core with the header's parameters that has not stepped; it may be called
// twice. Errors and `keep_going` as Replay (replay.h).
Result<Moment> ReplayToMoment(const std::function<std::unique_ptr<core::Core>()>& make_core,
                              const Header& header, std::span<const Bytes> chunks,
                              const MomentOptions& options, Keyframes& keyframes,
                              const std::function<bool(double progress)>& keep_going = {});

}  // namespace enamel::trace
