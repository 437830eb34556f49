#include "common/trace/replay.h"

#include <chrono>
#include <string>

#include "common/trace/replay_run.h"

namespace enamel::trace {

Result<ReplayReport> Replay(
    core::Core& core, const Header& header, std::span<const Bytes> chunks,
    const std::function<void(const Tick&, const core::TickOutput&)>& observe,
    const std::function<bool(double progress)>& keep_going) {
  auto begin = std::chrono::steady_clock::now();
  ReplayRun run(core, header);
  ENAMEL_RETURN_IF_ERROR(run.CheckCore());
  for (const Bytes& bytes : chunks) {
    ENAMEL_RETURN_IF_ERROR(run.CheckKeepGoing(keep_going, chunks.size()));
    ENAMEL_RETURN_IF_ERROR(run.Run(bytes, UINT64_MAX, observe));
  }
  // Also where there was no chunk.
  run.report().state_hash = core.state_hash();
  run.report().seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return run.report();
}

}  // namespace enamel::trace
