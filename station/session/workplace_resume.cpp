#include <algorithm>

#include "common/scene/plan.h"
#include "common/trace/replay_run.h"
#include "station/session/workplace.h"

namespace enamel::station {
Result<std::vector<SpooledAttempt>> Workplace::Unfinished() {
  auto all = spool_->List();
  if (all.ok()) {
    std::erase_if(*all, [](const SpooledAttempt& a) { return a.seal || !a.refused.empty(); });
  }
  return all;
}

Result<std::vector<SpooledAttempt>> Workplace::UnfinishedOf(const Uuid& person) {
  auto all = Unfinished();
  ENAMEL_RETURN_IF_ERROR(all.status());
  std::vector<SpooledAttempt> out;
  for (SpooledAttempt& a : *all) {
    ENAMEL_ASSIGN_OR_RETURN(auto header, HeaderOf(a.id));
    if (header.ticket.person == person) out.push_back(std::move(a));
  }
  return out;
}

Result<std::vector<SpooledAttempt>> Workplace::HandedInOf(const Uuid& person, size_t most) {
  auto all = spool_->List();
  ENAMEL_RETURN_IF_ERROR(all.status());
  std::ranges::reverse(*all);
  std::vector<SpooledAttempt> out;
  for (SpooledAttempt& a : *all) {
    if (out.size() == most) break;
    if (!a.seal || !a.refused.empty()) continue;
    ENAMEL_ASSIGN_OR_RETURN(auto header, HeaderOf(a.id));
    if (header.ticket.person == person) out.push_back(std::move(a));
  }
  return out;
}

Result<trace::Header> Workplace::HeaderOf(const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, spool_->HeaderOf(attempt));
  return trace::DecodeHeader(bytes);
}

Result<PreparedAttempt> Workplace::PrepareResume(const Uuid& attempt, const KeepGoing& keep_going) {
  ENAMEL_ASSIGN_OR_RETURN(auto header, HeaderOf(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto who, SignedIn(*UseLink()));
  if (who.id != header.ticket.person) {
    return Status(Code::kForbidden,
                  "attempt " + attempt.Text() +
                      " is somebody else's: only the person who began it can resume it");
  }
  return Replayed(header, keep_going);
}

Result<PreparedAttempt> Workplace::PrepareResume(const Uuid& attempt, const std::string& pin,
                                                 const KeepGoing& keep_going) {
  ENAMEL_ASSIGN_OR_RETURN(auto header, HeaderOf(attempt));
  ENAMEL_RETURN_IF_ERROR(safe_.Open(attempt, pin).status());
  return Replayed(header, keep_going);
}

// The documents that a recording was made of, from the cache, with its header.
Result<PreparedAttempt> Workplace::OfHeader(const trace::Header& header) {
  auto prepared = FromCache(header.ticket.exercise, header.ticket.profile);
  ENAMEL_RETURN_IF_ERROR(prepared.status());
  // Parameters with another delay than the profile's belong to this version too.
  Status params =
      scene::CheckParams(prepared->scene, prepared->exercise, prepared->profile, header.params);
  if (params.code() == Code::kConflict && params.field() == "params") {
    return Status(
        Code::kVersion,
        "attempt " + header.ticket.attempt.Text() + " was begun by another version of this program",
        "params");
  }
  ENAMEL_RETURN_IF_ERROR(params);
  prepared->header = header;
  return prepared;
}

Result<std::unique_ptr<LookBack>> Workplace::LookBackAt(const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(auto header, HeaderOf(attempt));
  // Without the link, which may be waiting for a server that hangs.
  const auto who = person();
  if (!who) return Status(Code::kUnauthenticated, "nobody is signed in");
  if (who->id != header.ticket.person) {
    return Status(Code::kForbidden, "attempt " + attempt.Text() +
                                        " is somebody else's: only the person who made it can "
                                        "look back at it here");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto prepared, OfHeader(header));
  ENAMEL_ASSIGN_OR_RETURN(auto file, spool_->Export(attempt));
  return std::make_unique<LookBack>(std::move(prepared), std::move(file));
}

Result<PreparedAttempt> Workplace::Replayed(const trace::Header& header,
                                            const KeepGoing& keep_going) {
  const Uuid& attempt = header.ticket.attempt;
  ENAMEL_ASSIGN_OR_RETURN(auto stored, spool_->Get(attempt));
  if (stored.seal) {
    return Status(Code::kConflict,
                  "attempt " + attempt.Text() + " has ended: it cannot be resumed");
  }
  auto prepared = OfHeader(header);
  if (prepared.status().code() == Code::kVersion) {
    return Status(Code::kVersion,
                  prepared.status().message() +
                      " and cannot be resumed by this one; 'enamel-station spool close' ends it "
                      "where it stopped");
  }
  ENAMEL_RETURN_IF_ERROR(prepared.status());
  prepared->terms = stored.terms;
  prepared->core = std::make_unique<core::Core>(header.params, prepared->volume);
  // The tooth's state is computed, not stored: this proves that the attempt continues as recorded,
  // and the spool needs no room for it.
  trace::ReplayRun run(*prepared->core, prepared->header);
  ENAMEL_RETURN_IF_ERROR(run.CheckCore());
  // Half a minute of ticks: few enough for memory, many enough to read quickly.
  constexpr size_t kChunksAtOnce = 64;
  while (run.chain().next_seq < stored.chunks) {
    ENAMEL_ASSIGN_OR_RETURN(auto chunks,
                            spool_->ChunksFrom(attempt, run.chain().next_seq, kChunksAtOnce));
    for (const SpooledChunk& chunk : chunks) {
      ENAMEL_RETURN_IF_ERROR(run.CheckKeepGoing(keep_going, stored.chunks));
      ENAMEL_RETURN_IF_ERROR(run.Run(chunk.bytes, UINT64_MAX));
    }
    if (chunks.empty() || !run.report().witness_ok) break;
  }
  if (!run.report().witness_ok || run.chain().next_seq != stored.chunks) {
    return Status(
        Code::kConflict,
        "attempt " + attempt.Text() + " does not replay to what was recorded (tick " +
            std::to_string(run.report().first_bad_tick) +
            "): it cannot be resumed; 'enamel-station spool close' ends it where it stopped");
  }
  prepared->place = run.chain();
  ENAMEL_RETURN_IF_ERROR(MeasureGap(*prepared));
  return prepared;
}

Status Workplace::MeasureGap(PreparedAttempt& prepared) {
  ENAMEL_ASSIGN_OR_RETURN(auto silence, spool_->SilenceOf(prepared.attempt()));
  const double ticks = static_cast<double>(silence.ms) * 1e-3 * prepared.header.params.rate_hz;
  // At least one, so that the gap shows.
  prepared.gap_ticks = static_cast<uint32_t>(std::clamp(ticks, 1.0, 4294967295.0));
  prepared.clock_stepped = silence.clock_stepped;
  return Status::Ok();
}

Result<trace::Seal> Workplace::Close(const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(auto lock, spool_->LockForRecording());
  auto seal = spool_->CloseAttempt(attempt);
  // In every case: an existing seal may be waiting to be sent.
  uploader_.Wake();
  return seal;
}

}  // namespace enamel::station
