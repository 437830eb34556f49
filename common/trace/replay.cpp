#include "common/trace/replay.h"

#include <chrono>
#include <string>

#include "common/trace/replay_run.h"

namespace enamel::trace {

Result<ReplayReport> Replay(
    core::Core& core, const Header& header, const NextChunk& next, size_t count,
    const std::function<void(const Tick&, const core::TickOutput&)>& observe,
    const std::function<bool(double progress)>& keep_going, AfterDifference after) {
  auto begin = std::chrono::steady_clock::now();
  ReplayRun run(core, header);
  ENAMEL_RETURN_IF_ERROR(run.CheckCore());
  for (;;) {
    ENAMEL_ASSIGN_OR_RETURN(const auto chunk, next());
    if (!chunk.has_value()) break;
    ENAMEL_RETURN_IF_ERROR(run.CheckKeepGoing(keep_going, count));
    ENAMEL_RETURN_IF_ERROR(run.Run(*chunk, UINT64_MAX, observe));
    if (!run.report().witness_ok && after == AfterDifference::kStop) break;
  }
  // Also where there was no chunk.
  run.report().state_hash = core.state_hash();
  run.report().seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return run.report();
}

Result<ReplayReport> Replay(
    core::Core& core, const Header& header, std::span<const Bytes> chunks,
    const std::function<void(const Tick&, const core::TickOutput&)>& observe,
    const std::function<bool(double progress)>& keep_going) {
  return Replay(core, header, EachOf(chunks), chunks.size(), observe, keep_going);
}

}  // namespace enamel::trace
