#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>

#include "common/program/example.h"
#include "common/program/log.h"
#include "common/timeline/player.h"
#include "common/timeline/recorder.h"
#include "common/timeline/start_tooth.h"
#include "common/trace/replay.h"
#include "station/lab/bench/bench.h"
#include "station/lab/cutting/attempt.h"

// Bytes and times of playing back an attempt with the tooth being cut.
namespace enamel::station::lab::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct TimelineOptions {
  std::string json;
  std::vector<int> voxels_um = {100, 50};
  uint64_t ticks = 600'000;
  uint32_t change_frames = timeline::RecorderOptions().change_frames;
};

constexpr double kStartGoal_mb = 0.8, kTimelineGoal_mb = 15, kScrubGoal_ms = 100;

double Seconds(Clock::time_point from) {
  return std::chrono::duration<double>(Clock::now() - from).count();
}

struct TimelineFigures {
  size_t start_bytes = 0, timeline_bytes = 0, part_bytes = 0, coarse_bytes = 0, end_bytes = 0,
         key_bytes = 0, pose_bytes = 0, change_bytes = 0;
  uint32_t frames = 0, cut_bricks = 0;
  double start_s = 0, replay_s = 0, replay_with_timeline_s = 0, open_s = 0, scrub_p95_ms = 0,
         play_s = 0;
};

Status ReplayInto(const Attempt& attempt, timeline::Recorder* recorder, Bytes& out, double& took) {
  core::Core core(attempt.header.params, attempt.built.volume);
  const auto from = Clock::now();
  auto report =
      trace::Replay(core, attempt.header, attempt.chunks,
                    [&](const trace::Tick& tick, const core::TickOutput& output) {
                      if (recorder == nullptr) return;
                      recorder->Add(core.volume(), core.touched(),
                                    {output.anchor, (tick.input.flags & core::kBurOn) != 0,
                                     tick.input.gap_ticks, core.bur()});
                    });
  ENAMEL_RETURN_IF_ERROR(report.status());
  if (recorder != nullptr) out = recorder->Finish(core.volume());
  took = Seconds(from);
  return Status::Ok();
}

Status MeasurePlayer(const Bytes& start, const Bytes& file, TimelineFigures& out) {
  auto from = Clock::now();
  ENAMEL_ASSIGN_OR_RETURN(auto player, timeline::Player::Open(start, file));
  out.open_s = Seconds(from);
  const timeline::Head& head = player.head();
  out.frames = head.frames();
  for (const timeline::Segment& segment : head.segments) {
    out.key_bytes += segment.key_bytes;
    out.pose_bytes += segment.pose_bytes;
    out.change_bytes += segment.change_bytes;
    out.cut_bricks = std::max(out.cut_bricks, segment.key_bricks);
  }
  out.part_bytes = size_t{head.end_bytes} + head.still_bytes + head.changing_bytes;
  out.coarse_bytes = head.bytes() + head.end_bytes + head.still_bytes;
  out.end_bytes = head.bytes() + out.part_bytes;
  if (!head.segments.empty()) out.end_bytes += static_cast<size_t>(head.segments.back().bytes());
  std::vector<double> scrubs_ms;
  uint64_t at = 1;
  for (int i = 0; i < 200; ++i) {
    // An order that jumps back and forth over all of it (Knuth's multiplier).
    at = (at * 2654435761u + 12345) % (out.frames + 1);
    from = Clock::now();
    ENAMEL_RETURN_IF_ERROR(player.Seek(static_cast<uint32_t>(at)));
    scrubs_ms.push_back(1e3 * Seconds(from));
  }
  std::ranges::sort(scrubs_ms);
  out.scrub_p95_ms = scrubs_ms[scrubs_ms.size() * 95 / 100];
  from = Clock::now();
  for (uint32_t f = 0; f <= out.frames; ++f) ENAMEL_RETURN_IF_ERROR(player.Seek(f));
  out.play_s = Seconds(from);
  return Status::Ok();
}

Result<TimelineFigures> MeasureTimelineAt(int voxel_um, const TimelineOptions& options,
                                          Progress& progress) {
  AttemptOptions how;
  how.voxel_nm = voxel_um * 1000;
  how.ticks = options.ticks;
  ENAMEL_ASSIGN_OR_RETURN(auto attempt, RecordAttempt(how, [&](double ratio) {
                            progress.Show("attempt at " + std::to_string(voxel_um) + " um", ratio);
                          }));
  TimelineFigures out;
  auto from = Clock::now();
  const Bytes start = timeline::EncodeStartTooth(timeline::StartToothOf(attempt.built.volume));
  out.start_s = Seconds(from);
  out.start_bytes = start.size();
  Bytes file;
  ENAMEL_RETURN_IF_ERROR(ReplayInto(attempt, nullptr, file, out.replay_s));
  timeline::RecorderOptions recording;
  recording.ticks = options.ticks;
  recording.burs = core::BursOf(attempt.header.params);
  recording.change_frames = options.change_frames;
  timeline::Recorder recorder(attempt.built.volume, HashSha256(start), recording);
  ENAMEL_RETURN_IF_ERROR(ReplayInto(attempt, &recorder, file, out.replay_with_timeline_s));
  out.timeline_bytes = file.size();
  ENAMEL_RETURN_IF_ERROR(MeasurePlayer(start, file, out));
  return out;
}

int RunTimeline(const TimelineOptions& options) {
  if (!CanWrite(options.json)) return 1;
  const std::string method =
      "a class I cavity on the built-in molar, recorded through the core; the start tooth packed; "
      "the replay without and with the timeline made in the same pass; the bytes that show a "
      "coarse tooth and the end; the file's parts; then the "
      "C++ player: 200 seeks to and fro (95th percentile), and every frame in order. Meshing is "
      "not in it. One thread";
  std::printf("Method: %s.\n\n%6s %8s %9s %9s %9s %9s %9s %9s %9s %9s %7s %8s %9s %8s %9s %8s\n",
              method.c_str(), "voxel", "ticks", "start kB", "all kB", "poses kB", "keys kB",
              "chg kB", "parts kB", "coarse kB", "end kB", "bricks", "start s", "replay s",
              "with it", "scrub ms", "play s");
  Rows rows("timeline", method);
  std::string goals;
  for (int voxel_um : options.voxels_um) {
    Progress progress;
    auto f = MeasureTimelineAt(voxel_um, options, progress);
    if (!f.ok()) {
      program::SayError(f.status().message());
      return 1;
    }
    progress.Clear();
    const auto kb = [](size_t bytes) { return static_cast<double>(bytes) * 1e-3; };
    std::printf(
        "%6.3f %8llu %9.1f %9.1f %9.1f %9.1f %9.1f %9.1f %9.1f %9.1f %7u %8.3f %9.3f %8.3f %9.2f "
        "%8.3f\n",
        voxel_um * 1e-3, static_cast<unsigned long long>(options.ticks), kb(f->start_bytes),
        kb(f->timeline_bytes), kb(f->pose_bytes), kb(f->key_bytes), kb(f->change_bytes),
        kb(f->part_bytes), kb(f->coarse_bytes), kb(f->end_bytes), f->cut_bricks, f->start_s,
        f->replay_s, f->replay_with_timeline_s, f->scrub_p95_ms, f->play_s);
    const std::string at = " at " + std::to_string(voxel_um) + " um";
    goals += "  first picture" + at +
             ", MB: " + AgainstGoal(kb(f->end_bytes) * 1e-3, kStartGoal_mb) + "\n";
    goals += "  whole timeline" + at +
             ", MB: " + AgainstGoal(kb(f->timeline_bytes) * 1e-3, kTimelineGoal_mb) + "\n";
    goals += "  seek" + at + ", p95 ms: " + AgainstGoal(f->scrub_p95_ms, kScrubGoal_ms) + "\n";
    rows.Add({{"voxel_mm", voxel_um * 1e-3},
              {"ticks", options.ticks},
              {"frames", f->frames},
              {"start_bytes", f->start_bytes},
              {"timeline_bytes", f->timeline_bytes},
              {"pose_bytes", f->pose_bytes},
              {"key_bytes", f->key_bytes},
              {"change_bytes", f->change_bytes},
              {"part_bytes", f->part_bytes},
              {"coarse_bytes", f->coarse_bytes},
              {"end_bytes", f->end_bytes},
              {"cut_bricks", f->cut_bricks},
              {"start_s", f->start_s},
              {"replay_s", f->replay_s},
              {"replay_with_timeline_s", f->replay_with_timeline_s},
              {"open_s", f->open_s},
              {"seek_p95_ms", f->scrub_p95_ms},
              {"play_s", f->play_s}});
  }
  std::printf("\nGoals:\n%s", goals.c_str());
  return rows.Write(options.json);
}

}  // namespace

void RegisterTimeline(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<TimelineOptions>();
  CLI::App* timeline = app.add_subcommand(
      "timeline", "Bytes and times of playing an attempt back with the tooth being cut");
  timeline->add_option("--voxel-um", options->voxels_um, "Voxel sizes")
      ->delimiter(',')
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  timeline->add_option("--ticks", options->ticks, "Length of the attempt at 1 kHz")
      ->check(CLI::Range(20'000, 3'600'000))
      ->capture_default_str();
  timeline
      ->add_option("--change-frames", options->change_frames,
                   "The tooth changes in every so many frames")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  timeline->add_option("--json", options->json, "Write the rows to this file");
  program::AddExamples(*timeline, {"--voxel-um 50"});
  timeline->callback([options, exit_code] { *exit_code = RunTimeline(*options); });
}

}  // namespace enamel::station::lab::bench
