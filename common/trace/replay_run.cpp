#include "common/trace/replay_run.h"

#include <string>

namespace enamel::trace {
namespace {

// Name of the first field in which the core's result and the recorded witness differ; nullptr if
// none.
const char* Difference(const core::TickWitness& recorded, const core::TickWitness& computed) {
  if (recorded.force_sent_mn != computed.force_sent_mn) return "force_sent";
  if (recorded.force_computed_mn != computed.force_computed_mn) return "force_computed";
  if (recorded.anchor_100nm != computed.anchor_100nm) return "anchor";
  if (recorded.flags != computed.flags) return "flags";
  return nullptr;
}

}  // namespace

ReplayRun::ReplayRun(core::Core& core, const Header& header)
    : core_(core),
      header_(header),
      chain_(header.ticket.attempt, HashSha256(EncodeHeader(header))) {}

Status ReplayRun::CheckCore() const {
  if (core_.ticks() != 0) {
    return Status(Code::kInvalidInput,
                  "replay: expected a core that has not stepped yet, found one at tick " +
                      std::to_string(core_.ticks()));
  }
  if (core_.params() != header_.params) {
    return Status(Code::kInvalidInput,
                  "replay: the core was not made with the parameters of the recording's header",
                  "params");
  }
  return Status::Ok();
}

void ReplayRun::NoteFirst(uint64_t tick, const char* what) {
  if (!report_.witness_ok) return;
  report_.witness_ok = false;
  report_.first_bad_tick = tick;
  report_.first_bad_chunk = report_.chunks;
  report_.what = what;
}

template <typename Decoded>
Status ReplayRun::Accept(const Decoded& chunk) {
  if (!chunk.ok()) {
    return Status(chunk.status().code(),
                  "chunk " + std::to_string(report_.chunks) + ": " + chunk.status().message(),
                  chunk.status().field());
  }
  return chain_.Accept(*chunk);
}

Status ReplayRun::Skip(const Bytes& bytes) {
  ENAMEL_RETURN_IF_ERROR(Accept(DecodeChunkHead(bytes)));
  ++report_.chunks;
  return Status::Ok();
}

void ReplayRun::StartAt(uint64_t gap_ticks) {
  report_.ticks = core_.ticks();
  report_.gap_ticks = gap_ticks;
}

Status ReplayRun::Run(const Bytes& bytes, uint64_t until_tick, const TickObserver& observe) {
  auto chunk = DecodeChunk(bytes);
  ENAMEL_RETURN_IF_ERROR(Accept(chunk));
  for (const Tick& tick : chunk->ticks) {
    if (report_.ticks == until_tick) break;
    const size_t bur = core::BurIn(tick.input.flags), burs = core::BurCount(header_.params);
    if (bur >= burs) {
      return Status(Code::kInvalidInput,
                    "tick " + std::to_string(report_.ticks) + " names bur " + std::to_string(bur) +
                        ", the recording has burs 0 to " + std::to_string(burs - 1),
                    "input flags");
    }
    core::TickOutput out = core_.Step(tick.input);
    // Continues: only the first disagreement is reported, but the counts are the recording's.
    if (const char* what = Difference(tick.witness, out.witness)) NoteFirst(report_.ticks, what);
    if (observe) observe(tick, out);
    ++report_.ticks;
    report_.gap_ticks += tick.input.gap_ticks;
  }
  report_.state_hash = core_.state_hash();
  // Stopped within the chunk: its state hash is that of its end and says nothing here.
  if (report_.ticks != chain_.next_tick()) return Status::Ok();
  if (core_.state_hash() != chunk->head.state_hash) NoteFirst(report_.ticks - 1, "state_hash");
  ++report_.chunks;
  return Status::Ok();
}

Status ReplayRun::CheckKeepGoing(const std::function<bool(double)>& keep_going,
                                 size_t chunks) const {
  if (!keep_going ||
      keep_going(static_cast<double>(report_.chunks) / static_cast<double>(chunks))) {
    return Status::Ok();
  }
  return Status(Code::kUnavailable, "replay was stopped after " + std::to_string(report_.chunks) +
                                        " of " + std::to_string(chunks) + " chunks");
}

}  // namespace enamel::trace
