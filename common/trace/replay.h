#pragma once

#include <functional>
#include <span>

#include "common/base/result.h"
#include "common/core/core.h"
#include "common/trace/pieces.h"
#include "common/trace/trace.h"

namespace enamel::trace {

// The findings of a re-run of the core on a recording.
struct ReplayReport {
  uint64_t ticks = 0;
  uint32_t chunks = 0;
  uint64_t gap_ticks = 0;
  bool witness_ok = true;  // every tick's witness and every chunk's state hash agreed
  // Where the first disagreement is, when there is one.
  uint64_t first_bad_tick = 0;
  uint32_t first_bad_chunk = 0;
  std::string what;  // "force_sent", "anchor", "flags", "state_hash"
  uint64_t state_hash = 0;
  double seconds = 0;  // wall time, for the real-time factor
};

// A re-run continues behind the chunk of the first disagreement, to count the rest, or stops there.
enum class AfterDifference { kContinue, kStop };

// Re-runs `core` over chunks in order, comparing the witness tick by tick and the state hash chunk
// by chunk. `observe` (may be empty) sees every tick with its output: metrics are computed there,
// in the same pass. `count`: how many chunks `next` gives, for `keep_going`, which hears of
// progress; returning false it stops with kUnavailable. One chunk is in memory at a time. Errors:
// what `next` returns; undecodable or broken chain.
Result<ReplayReport> Replay(
    core::Core& core, const Header& header, const NextChunk& next, size_t count,
    const std::function<void(const Tick&, const core::TickOutput&)>& observe = {},
    const std::function<bool(double progress)>& keep_going = {},
    AfterDifference after = AfterDifference::kContinue);
// Re-runs the core over chunks that are in memory.
Result<ReplayReport> Replay(
    core::Core& core, const Header& header, std::span<const Bytes> chunks,
    const std::function<void(const Tick&, const core::TickOutput&)>& observe = {},
    const std::function<bool(double progress)>& keep_going = {});

}  // namespace enamel::trace
