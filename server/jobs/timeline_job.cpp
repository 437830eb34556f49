#include "server/jobs/timeline_job.h"

#include <string>
#include <vector>

#include "common/scene/volume_blob.h"
#include "common/timeline/recorder.h"
#include "common/timeline/start_tooth.h"
#include "common/trace/replay.h"

namespace enamel::server {
namespace {

Status Stopped() {
  return Status(Code::kUnavailable, "stopped: the timeline is made when nobody waits for a score");
}

Result<Sha256> StartTooth(StoredBlobs& blobs, TimelineRows& timelines, const Sha256& volume_hash,
                          const cutting::Volume& volume) {
  ENAMEL_ASSIGN_OR_RETURN(Sha256 known, timelines.StartToothOf(volume_hash));
  if (!known.IsZero()) return known;
  ENAMEL_ASSIGN_OR_RETURN(
      Sha256 made, blobs.PutBlob(timeline::EncodeStartTooth(timeline::StartToothOf(volume))));
  ENAMEL_RETURN_IF_ERROR(timelines.PutStartTooth(volume_hash, made));
  return made;
}

Status Make(Store& store, const Uuid& attempt, const JobProgress& progress) {
  ENAMEL_ASSIGN_OR_RETURN(const Bytes header_bytes, store.recordings.AttemptHeader(attempt));
  ENAMEL_ASSIGN_OR_RETURN(const trace::Header header, trace::DecodeHeader(header_bytes));
  ENAMEL_RETURN_IF_ERROR(core::ValidateParams(header.params));
  ENAMEL_ASSIGN_OR_RETURN(const std::vector<Bytes> chunks, store.recordings.AttemptChunks(attempt));
  ENAMEL_ASSIGN_OR_RETURN(const Bytes volume, store.blobs.GetBlob(header.volume));
  ENAMEL_ASSIGN_OR_RETURN(const cutting::Volume initial, scene::DecodeVolume(volume));
  ENAMEL_ASSIGN_OR_RETURN(const Sha256 start,
                          StartTooth(store.blobs, store.timelines, header.volume, initial));
  timeline::RecorderOptions options;
  options.rate_hz = header.params.rate_hz;
  options.bur = core::BurOf(header.params);
  // A tenth of a second, whatever the loop's rate.
  options.frame_ticks = std::max(1u, header.params.rate_hz / 10);
  timeline::Recorder recorder(initial, start, options);
  core::Core core(header.params, initial);
  auto report = trace::Replay(
      core, header, chunks,
      [&](const trace::Tick& tick, const core::TickOutput& output) {
        recorder.Add(core.volume(), core.touched(),
                     {output.anchor, (tick.input.flags & core::kBurOn) != 0, tick.input.gap_ticks});
      },
      progress);
  if (!report.ok())
    return report.status().code() == Code::kUnavailable ? Stopped() : report.status();
  if (!report->witness_ok) {
    return Status(Code::kConflict, "replay and recording part at tick " +
                                       std::to_string(report->first_bad_tick) +
                                       "; there is no tooth to play back");
  }
  ENAMEL_ASSIGN_OR_RETURN(const Sha256 content,
                          store.blobs.PutAttemptBlob(attempt, recorder.Finish(core.volume())));
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
