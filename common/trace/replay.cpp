#include "common/trace/replay.h"

#include <chrono>
#include <string>

namespace enamel::trace {
namespace {

// Name of the first field in which the core's result and the recorded witness differ; nullptr if
// none.
const char* Difference(const core::TickWitness& recorded, const core::TickWitness& computed) {
  if (recorded.force_sent_100un != computed.force_sent_100un) return "force_sent";
  if (recorded.force_computed_100un != computed.force_computed_100un) return "force_computed";
  if (recorded.anchor_10nm != computed.anchor_10nm) return "anchor";
  if (recorded.flags != computed.flags) return "flags";
  return nullptr;
}

void NoteFirst(ReplayReport& report, uint64_t tick, uint32_t chunk, const char* what) {
  if (!report.witness_ok) return;
  report.witness_ok = false;
  report.first_bad_tick = tick;
  report.first_bad_chunk = chunk;
  report.what = what;
}

Status CheckCore(const core::Core& core, const Header& header) {
  if (core.ticks() != 0) {
    return Status(Code::kInvalidInput,
                  "replay: expected a core that has not stepped yet, found one at tick " +
                      std::to_string(core.ticks()));
  }
  if (core.params() != header.params) {
    return Status(Code::kInvalidInput,
                  "replay: the core was not made with the parameters of the recording's header",
                  "params");
  }
  return Status::Ok();
}

}  // namespace

Result<ReplayReport> Replay(
    core::Core& core, const Header& header, std::span<const Bytes> chunks,
    const std::function<void(const Tick&, const core::TickOutput&)>& observe,
    const std::function<bool(double progress)>& keep_going) {
  ENAMEL_RETURN_IF_ERROR(CheckCore(core, header));
  auto begin = std::chrono::steady_clock::now();
  ReplayReport report;
  ChainVerifier chain(header.ticket.attempt, HashSha256(EncodeHeader(header)));
  for (const Bytes& bytes : chunks) {
    if (keep_going &&
        !keep_going(static_cast<double>(report.chunks) / static_cast<double>(chunks.size()))) {
      return Status(Code::kUnavailable, "replay was stopped after " +
                                            std::to_string(report.chunks) + " of " +
                                            std::to_string(chunks.size()) + " chunks");
    }
    auto chunk = DecodeChunk(bytes);
    if (!chunk.ok()) {
      return Status(chunk.status().code(),
                    "chunk " + std::to_string(report.chunks) + ": " + chunk.status().message(),
                    chunk.status().field());
    }
    ENAMEL_RETURN_IF_ERROR(chain.Accept(*chunk));
    for (const Tick& tick : chunk->ticks) {
      core::TickOutput out = core.Step(tick.input);
      if (const char* what = Difference(tick.witness, out.witness)) {
        NoteFirst(report, report.ticks, report.chunks, what);
      }
      if (observe) observe(tick, out);
      ++report.ticks;
      report.gap_ticks += tick.input.gap_ticks;
    }
    if (core.state_hash() != chunk->head.state_hash) {
      NoteFirst(report, report.ticks - 1, report.chunks, "state_hash");
    }
    ++report.chunks;
  }
  report.state_hash = core.state_hash();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return report;
}

}  // namespace enamel::trace
