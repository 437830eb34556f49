#include "common/trace/replay.h"

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>

#include "common/program/example.h"
#include "common/program/log.h"
#include "common/trace/moment.h"
#include "station/lab/bench/bench.h"
#include "station/lab/cutting/attempt.h"

namespace enamel::station::lab::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct ReplayOptions {
  std::string json;
  std::vector<int> voxels_um = {100, 50, 25};
  uint64_t ticks = 600'000;
  int replays = 3;
};

constexpr double kFactorGoal = 75, kReachGoal_s = 1;

struct Reach {
  double worst_s = 0, mean_s = 0;
  size_t keyframes = 0, bytes = 0;
};

// Moments spread over the attempt, reached as `enamel-station replay --to-tick` does: the bytes of
// trace and keyframes are in memory, everything else is timed.
Result<Reach> MeasureReach(const Attempt& attempt, const trace::Keyframes& made) {
  constexpr int kMoments = 20;
  // Encoded once and decoded for each moment, because reading the file is part of it.
  Bytes bytes = made.Encode();
  Reach out{0, 0, made.size(), bytes.size()};
  uint64_t ticks = attempt.seal.ticks;
  for (int i = 1; i <= kMoments; ++i) {
    auto from = std::chrono::steady_clock::now();
    ENAMEL_ASSIGN_OR_RETURN(
        auto keyframes,
        trace::Keyframes::Decode(bytes, HashSha256(trace::EncodeHeader(attempt.header))));
    trace::MomentOptions options;
    // Not round numbers: a moment just before a keyframe is as likely as one just after.
    options.to_tick = ticks * static_cast<uint64_t>(i) / kMoments - static_cast<uint64_t>(137 * i);
    auto moment = trace::ReplayToMoment(
        [&] { return std::make_unique<core::Core>(attempt.header.params, attempt.built.volume); },
        attempt.header, attempt.chunks, options, keyframes);
    ENAMEL_RETURN_IF_ERROR(moment.status());
    double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
    out.worst_s = std::max(out.worst_s, s);
    out.mean_s += s / kMoments;
  }
  return out;
}

// Seconds per chunk.
Result<std::vector<double>> TimeChunks(const Attempt& attempt) {
  core::Core core(attempt.header.params, attempt.built.volume);
  std::vector<Clock::time_point> marks;
  // One mark as each chunk begins, and one at the end; reserved, so that no mark costs an
  // allocation.
  marks.reserve(attempt.chunks.size() + 1);
  auto report = trace::Replay(core, attempt.header, attempt.chunks, {}, [&](double) {
    marks.push_back(Clock::now());
    return true;
  });
  marks.push_back(Clock::now());
  ENAMEL_RETURN_IF_ERROR(report.status());
  // The time of a wrong replay is worthless.
  if (!report->witness_ok || report->state_hash != attempt.seal.state_hash) {
    return Status(Code::kConflict, "the replay disagrees with the recording");
  }
  std::vector<double> out;
  for (size_t i = 1; i < marks.size(); ++i) {
    out.push_back(std::chrono::duration<double>(marks[i] - marks[i - 1]).count());
  }
  return out;
}

struct Speed {
  double least_s = 0;  // per chunk the least of the replays, summed
  double raw_s = 0;    // mean of the replays as they came
};

Result<Speed> MeasureSpeed(const Attempt& attempt, int replays,
                           const std::function<void(double)>& progress) {
  Speed out;
  std::vector<double> least;
  for (int r = 0; r < replays; ++r) {
    progress(static_cast<double>(r) / replays);
    ENAMEL_ASSIGN_OR_RETURN(auto times, TimeChunks(attempt));
    if (least.empty()) least = times;
    for (size_t i = 0; i < least.size(); ++i) {
      least[i] = std::min(least[i], times[i]);
      out.raw_s += times[i] / replays;
    }
  }
  // Chunk by chunk, not replay by replay: one disturbance spoils one chunk of one replay.
  for (double s : least) out.least_s += s;
  return out;
}

int Fail(const Status& status) {
  program::SayError(status.message());
  return 1;
}

int RunReplay(const ReplayOptions& options) {
  if (!CanWrite(options.json)) return 1;
  std::string method =
      "a class I cavity on the built-in molar, strokes at 2 mm/s with looking in between, recorded "
      "through the core and "
      "encoded as a station sends it; replayed on one core: chunks decoded, chain, every tick's "
      "witness and every "
      "chunk's state hash compared; seconds: per chunk of 500 ticks the least of several identical "
      "replays, summed; raw: the replays as they came. reach: time to a moment with keyframes, "
      "worst of 20 over the "
      "attempt";
  std::printf("Method: %s.\n\n%6s %8s %8s %9s %10s %10s %10s %10s %10s %9s\n", method.c_str(),
              "voxel", "ticks", "cutting", "replay s", "x real", "raw", "keyframes", "their MB",
              "reach s", "worst s");
  Rows rows("replay", method);
  std::string goals;
  for (int voxel_um : options.voxels_um) {
    AttemptOptions how;
    how.voxel_nm = voxel_um * 1000;
    how.ticks = options.ticks;
    Progress progress;
    auto attempt = RecordAttempt(how, [&](double ratio) {
      progress.Show("recording at " + std::to_string(voxel_um) + " um", ratio);
    });
    if (!attempt.ok()) return Fail(attempt.status());
    auto speed = MeasureSpeed(*attempt, options.replays, [&](double ratio) {
      progress.Show("replaying at " + std::to_string(voxel_um) + " um", ratio);
    });
    if (!speed.ok()) return Fail(speed.status());
    trace::Keyframes keyframes(HashSha256(trace::EncodeHeader(attempt->header)));
    trace::MomentOptions whole;
    // This whole replay makes the keyframes.
    whole.start_from_keyframe = false;
    auto moment = trace::ReplayToMoment(
        [&] { return std::make_unique<core::Core>(attempt->header.params, attempt->built.volume); },
        attempt->header, attempt->chunks, whole, keyframes,
        [&](double ratio) {
          progress.Show("making keyframes at " + std::to_string(voxel_um) + " um", ratio);
          return true;
        });
    if (!moment.ok()) return Fail(moment.status());
    auto reach = MeasureReach(*attempt, keyframes);
    if (!reach.ok()) return Fail(reach.status());
    double recorded_s = static_cast<double>(attempt->seal.ticks) / attempt->header.params.rate_hz;
    double factor = recorded_s / speed->least_s, raw_factor = recorded_s / speed->raw_s;
    progress.Clear();
    std::printf("%6.3f %8llu %6.1f %% %9.2f %10.1f %10.1f %10zu %10.2f %10.3f %9.3f\n",
                voxel_um * 1e-3, static_cast<unsigned long long>(attempt->seal.ticks),
                100 * attempt->cutting_share, speed->least_s, factor, raw_factor, reach->keyframes,
                static_cast<double>(reach->bytes) * 1e-6, reach->mean_s, reach->worst_s);
    if (voxel_um == 50) {
      goals = "  replay at 0.05 mm, x real time: " + AgainstGoal(factor, kFactorGoal, true) +
              "\n  worst moment at 0.05 mm: " + AgainstGoal(reach->worst_s, kReachGoal_s) + " s\n";
    }
    rows.Add({{"voxel_mm", voxel_um * 1e-3},
              {"ticks", attempt->seal.ticks},
              {"cutting_share", attempt->cutting_share},
              {"seconds", speed->least_s},
              {"raw_seconds", speed->raw_s},
              {"realtime_factor", factor},
              {"raw_realtime_factor", raw_factor},
              {"keyframes", reach->keyframes},
              {"keyframes_mb", static_cast<double>(reach->bytes) * 1e-6},
              {"reach_mean_s", reach->mean_s},
              {"reach_worst_s", reach->worst_s}});
  }
  if (!goals.empty()) std::printf("\nGoals:\n%s", goals.c_str());
  return rows.Write(options.json);
}

}  // namespace

void RegisterReplay(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* replay =
      app.add_subcommand("replay", "How fast an attempt is replayed, and a moment of it reached");
  replay->add_option("--voxel-um", options->voxels_um, "Voxel sizes")
      ->delimiter(',')
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  replay->add_option("--ticks", options->ticks, "Length of the attempt at 1 kHz")
      ->check(CLI::Range(20'000, 3'600'000))
      ->capture_default_str();
  replay->add_option("--replays", options->replays, "Identical replays")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  replay->add_option("--json", options->json, "Write the rows to this file");
  program::AddExamples(*replay, {"--voxel-um 50"});
  replay->callback([options, exit_code] { *exit_code = RunReplay(*options); });
}

}  // namespace enamel::station::lab::bench
