#include "station/app/recordings/replay.h"

#include <unistd.h>

#include <boost/json.hpp>
#include <cstdio>

#include "common/base/file.h"
#include "common/program/example.h"
#include "common/program/log.h"
#include "common/program/output.h"
#include "common/surface/ply.h"
#include "common/trace/moment.h"
#include "station/app/command_line.h"
#include "station/app/recordings/recording_file.h"
#include "station/app/simulate.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
using unsigned_ll = unsigned long long;

// TRACE.keyframes. A cache: an unreadable file is rebuilt, and a failed write does no harm.
class KeyframeFile {
 public:
  KeyframeFile(const ReplayOptions& options, const RecordingFile& recording)
      : path_(options.trace.string() + ".keyframes"),
        used_(options.keyframes),
        frames_(HashSha256(recording.file.header)) {
    std::error_code none;
    if (!used_ || !fs::exists(path_, none)) return;
    auto bytes = ReadFile(path_);
    if (!bytes.ok()) return;
    auto read = trace::Keyframes::Decode(*bytes, HashSha256(recording.file.header));
    if (read.ok()) {
      frames_ = std::move(*read);
      before_ = frames_.size();
    } else {
      std::printf("%s is unusable and is rebuilt (%s)\n", path_.c_str(),
                  read.status().message().c_str());
    }
  }
  trace::Keyframes& frames() { return frames_; }
  void Keep(bool discarded) {
    // Written only when it has changed: the file may be some MiB.
    if (!used_ || (!discarded && frames_.size() == before_) || frames_.size() == 0) return;
    if (Status s = WriteFileDurably(path_, frames_.Encode()); !s.ok()) {
      std::printf("keyframes are not kept: %s\n", s.message().c_str());
    }
  }

 private:
  fs::path path_;
  bool used_;
  trace::Keyframes frames_;
  size_t before_ = 0;
};

bool ProgressIsSeen() { return ::isatty(STDERR_FILENO) != 0 && !program::LogIsJson(); }

// One line on standard error, if it is a terminal.
bool ShowProgress(double ratio) {
  static int shown = -1;
  auto percent = static_cast<int>(100 * ratio);
  if (percent != shown && ProgressIsSeen()) {
    std::fprintf(stderr, "\rreplaying %3d %%", percent);
  }
  shown = percent;
  return true;
}

// As text in JSON too: many readers store numbers as doubles, which cannot hold 64 bits.
std::string Hex(uint64_t value) {
  char text[24];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned_ll>(value));
  return text;
}

void PrintMoment(const RecordingFile& recording, const trace::Moment& moment) {
  const trace::ReplayReport& r = moment.report;
  std::printf("attempt %s: %llu ticks in %u of %zu chunks, %llu ticks of gaps%s\n",
              recording.header.ticket.attempt.Text().c_str(), static_cast<unsigned_ll>(r.ticks),
              r.chunks, recording.file.chunks.size(), static_cast<unsigned_ll>(r.gap_ticks),
              moment.whole ? "" : "; stopped where asked");
  if (recording.file.truncated) {
    std::printf("the file is cut short: its whole chunks were used, the rest is lost\n");
  } else if (!recording.file.seal) {
    std::printf(
        "the recording has no seal: it was interrupted, or still running when it was exported\n");
  }
  if (!moment.discarded.empty())
    std::printf("keyframes thrown away: %s\n", moment.discarded.c_str());
}

// Prints, and returns for the JSON.
boost::json::object Removed(const core::Core& core) {
  auto removed = Removed_mm3(core.removed(), core.volume().spec().voxel_m());
  boost::json::object out;
  double sum = 0;
  for (size_t t = 1; t < removed.size(); ++t) {
    if (removed[t] == 0) continue;
    std::string name(cutting::kTissueNames[t]);
    std::printf("removed %-9s %8.3f mm3\n", name.c_str(), removed[t]);
    out[name] = removed[t];
    sum += removed[t];
  }
  std::printf("removed %-9s %8.3f mm3\n", "in all", sum);
  return out;
}

Status WriteSurface(const fs::path& path, const core::Core& core) {
  if (path.empty()) return Status::Ok();
  surface::Mesh mesh = surface::ExtractSurface(core.volume());
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(path, surface::EncodePly(mesh)));
  std::printf("%s: %zu triangles\n", path.c_str(), mesh.triangles.size());
  return Status::Ok();
}

Status Verdict(const trace::Moment& moment) {
  const trace::ReplayReport& r = moment.report;
  if (!r.witness_ok) {
    return Status(Code::kConflict, "the recording disagrees with the core at tick " +
                                       std::to_string(r.first_bad_tick) + " of chunk " +
                                       std::to_string(r.first_bad_chunk) + " (" + r.what + ")");
  }
  if (moment.from_tick == 0) {
    std::printf(
        "every tick agrees with the core; signatures were not checked (enamel-station verify does "
        "that)\n");
  } else {
    std::printf(
        "every tick from %llu on agrees with the core; without --to-tick all are compared\n",
        static_cast<unsigned_ll>(moment.from_tick));
  }
  return Status::Ok();
}

}  // namespace

Status ReplayTrace(const ReplayOptions& options) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.json, "--json"));
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.surface, "--surface"));
  ENAMEL_ASSIGN_OR_RETURN(auto recording, ReadRecordingFile(options.trace));
  ENAMEL_RETURN_IF_ERROR(core::ValidateParams(recording.header.params));
  ENAMEL_ASSIGN_OR_RETURN(auto volume,
                          ReadVolumeOf(recording.header, options.volume, options.data));
  auto make_core = [&] { return std::make_unique<core::Core>(recording.header.params, volume); };
  KeyframeFile keyframes(options, recording);
  trace::MomentOptions how;
  how.to_tick = options.to_tick;
  // Whole recordings are always stepped from the first tick: a keyframe is a cache, not proof.
  how.start_from_keyframe = options.to_tick != UINT64_MAX && options.keyframes;
  auto moment = trace::ReplayToMoment(make_core, recording.header, recording.file.chunks, how,
                                      keyframes.frames(), ShowProgress);
  if (ProgressIsSeen()) std::fprintf(stderr, "\r%20s\r", "");
  ENAMEL_RETURN_IF_ERROR(moment.status());
  keyframes.Keep(!moment->discarded.empty());

  const trace::ReplayReport& r = moment->report;
  // Counts from the keyframe: earlier ticks were not computed now and must not raise the speed.
  auto stepped = static_cast<double>(r.ticks - moment->from_tick);
  double per_second = r.seconds > 0 ? stepped / r.seconds : 0;
  double factor = per_second / recording.header.params.rate_hz;
  PrintMoment(recording, *moment);
  boost::json::object removed = Removed(*moment->core);
  std::printf("state hash %s\n", Hex(r.state_hash).c_str());
  std::printf(
      "re-ran %.0f ticks from tick %llu in %.3f s: %.0f ticks per second, %.0f x real time\n",
      stepped, static_cast<unsigned_ll>(moment->from_tick), r.seconds, per_second, factor);
  ENAMEL_RETURN_IF_ERROR(WriteSurface(options.surface, *moment->core));
  ENAMEL_RETURN_IF_ERROR(
      program::WriteJsonFile(options.json, {{"format", 1},
                                            {"attempt_id", recording.header.ticket.attempt.Text()},
                                            {"core_version", recording.header.params.core_version},
                                            {"ticks", r.ticks},
                                            {"chunks", r.chunks},
                                            {"gap_ticks", r.gap_ticks},
                                            {"whole", moment->whole},
                                            {"truncated", recording.file.truncated},
                                            {"sealed", recording.file.seal.has_value()},
                                            {"from_tick", moment->from_tick},
                                            {"witness_ok", r.witness_ok},
                                            {"state_hash", Hex(r.state_hash)},
                                            {"removed_mm3", std::move(removed)},
                                            {"seconds", r.seconds},
                                            {"ticks_per_second", per_second},
                                            {"realtime_factor", factor}}));
  // A replay that was stopped has not checked the rest, and makes no claim about it.
  if (moment->whole) ENAMEL_RETURN_IF_ERROR(CheckChain(recording));
  return Verdict(*moment);
}

void DeclareReplay(CommandGroup group) {
  auto [cmd, o] = Declare<ReplayOptions>(group, "replay",
                                         "Re-run the core on an exported recording and compare",
                                         [&place = group.place](ReplayOptions& options) {
                                           options.data = place.data;
                                           return ReplayTrace(options);
                                         });
  AddDataOption(*cmd, group.place);
  cmd->add_option("trace", o.trace, "File from 'spool export'")->required();
  cmd->add_option("--volume", o.volume, "The tooth it began with, when it is not in the cache");
  cmd->add_option("--to-tick", o.to_tick,
                  "Stop after this many ticks, starting from the keyframe before");
  cmd->add_option("--surface", o.surface,
                  "Write the tooth's surface there as PLY (mm, tissue per vertex)");
  cmd->add_flag("!--no-keyframes", o.keyframes,
                "Neither use nor write TRACE.keyframes, the cache beside the trace");
  cmd->add_option("--json", o.json, "Write what was found to this file");
  program::AddExamples(*cmd, {"last.entrace --surface cut.ply"});
}

}  // namespace enamel::station
