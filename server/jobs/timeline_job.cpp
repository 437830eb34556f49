#include "server/jobs/timeline_job.h"

#include <algorithm>
#include <string>
#include <vector>

#include "common/scene/volume_blob.h"
#include "common/timeline/deviation.h"
#include "common/timeline/recorder.h"
#include "common/timeline/start_tooth.h"
#include "common/trace/replay.h"

namespace enamel::server {
namespace {

Status Stopped() {
  return Status(Code::kUnavailable, "stopped: the timeline is made when nobody waits for a score");
}

// Remembers that the job was asked to end: what a stopped step returned is then of no use.
class Asked {
 public:
  explicit Asked(const JobProgress& progress) : progress_(progress) {}

  bool KeepGoing(double done) {
    is_over_ = is_over_ || (progress_ && !progress_(done));
    return !is_over_;
  }
  bool is_over() const { return is_over_; }

 private:
  const JobProgress& progress_;
  bool is_over_ = false;
};

Result<Sha256> StartTooth(StoredBlobs& blobs, TimelineRows& timelines, const Sha256& volume_hash,
                          const cutting::Volume& volume, Asked& asked) {
  ENAMEL_ASSIGN_OR_RETURN(Sha256 known, timelines.StartToothOf(volume_hash));
  if (!known.IsZero()) return known;
  const Bytes packed = timeline::EncodeStartTooth(timeline::StartToothOf(volume),
                                                  [&] { return asked.KeepGoing(0); });
  if (asked.is_over()) return Stopped();
  ENAMEL_ASSIGN_OR_RETURN(Sha256 made, blobs.PutBlob(packed));
  ENAMEL_RETURN_IF_ERROR(timelines.PutStartTooth(volume_hash, made));
  return made;
}

// Those that the attempt's deviation from its reference is known for: the reference may have cut
// where the attempt has not.
Result<std::vector<int32_t>> ComparedBricks(Store& store, const Uuid& attempt,
                                            const cutting::GridSpec& spec) {
  ENAMEL_ASSIGN_OR_RETURN(const AttemptResult result, store.results.ResultOf(attempt));
  ENAMEL_ASSIGN_OR_RETURN(const Bytes packed, store.blobs.GetBlob(result.deviation));
  ENAMEL_ASSIGN_OR_RETURN(const auto deviation, timeline::DecodeDeviation(packed));
  if (deviation.spec != spec) {
    return Status(Code::kConflict, "the attempt's deviation has another grid than its tooth");
  }
  std::vector<int32_t> out;
  for (const timeline::CellDeviation& value : deviation.cells) {
    out.push_back(spec.BrickIndex(value.cell / cutting::kBrickSide));
  }
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

Status Make(Store& store, const Uuid& attempt, const JobProgress& progress) {
  Asked asked(progress);
  ENAMEL_ASSIGN_OR_RETURN(const Bytes header_bytes, store.recordings.AttemptHeader(attempt));
  ENAMEL_ASSIGN_OR_RETURN(const trace::Header header, trace::DecodeHeader(header_bytes));
  ENAMEL_RETURN_IF_ERROR(core::ValidateParams(header.params));
  ENAMEL_ASSIGN_OR_RETURN(const auto recording, store.recordings.Open(attempt));
  ENAMEL_ASSIGN_OR_RETURN(const trace::Seal seal, store.recordings.AttemptSeal(attempt));
  ENAMEL_ASSIGN_OR_RETURN(const Bytes volume, store.blobs.GetBlob(header.volume));
  ENAMEL_ASSIGN_OR_RETURN(const cutting::Volume initial, scene::DecodeVolume(volume));
  ENAMEL_ASSIGN_OR_RETURN(const Sha256 start,
                          StartTooth(store.blobs, store.timelines, header.volume, initial, asked));
  timeline::RecorderOptions options;
  options.rate_hz = header.params.rate_hz;
  options.ticks = seal.ticks;
  options.burs = core::BursOf(header.params);
  // A tenth of a second, whatever the loop's rate.
  options.frame_ticks = std::max(1u, header.params.rate_hz / 10);
  ENAMEL_ASSIGN_OR_RETURN(options.detailed, ComparedBricks(store, attempt, initial.spec()));
  timeline::Recorder recorder(initial, start, options);
  core::Core core(header.params, initial);
  auto report = trace::Replay(
      core, header, recording.next, recording.chunks,
      [&](const trace::Tick& tick, const core::TickOutput& output) {
        recorder.Add(core.volume(), core.touched(),
                     {output.anchor, (tick.input.flags & core::kBurOn) != 0, tick.input.gap_ticks,
                      core.bur()});
      },
      [&](double done) { return asked.KeepGoing(done); }, trace::AfterDifference::kStop);
  if (!report.ok())
    return report.status().code() == Code::kUnavailable ? Stopped() : report.status();
  if (!report->witness_ok) {
    return Status(Code::kConflict, "replay and recording part at tick " +
                                       std::to_string(report->first_bad_tick) +
                                       "; there is no tooth to play back");
  }
  const Bytes file = recorder.Finish(core.volume(), [&] { return asked.KeepGoing(1); });
  if (asked.is_over()) return Stopped();
  ENAMEL_ASSIGN_OR_RETURN(const Sha256 content, store.blobs.PutAttemptBlob(attempt, file));
  return store.timelines.PutTimeline(attempt, content);
}

}  // namespace

Status RunTimelineJob(Store& store, const Uuid& attempt, const JobProgress& progress) {
  const Status status = Make(store, attempt, progress);
  if (status.ok() || status.code() == Code::kUnavailable) return status;
  const bool again = status.code() == Code::kStorage;
  const Status kept = store.timelines.FailTimeline(attempt, status.message(), again);
  return again ? status : kept;
}

}  // namespace enamel::server
