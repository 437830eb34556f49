#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>

#include "common/measure/attempt.h"
#include "common/trace/moment.h"
#include "tests/bench/cutting/bench.h"

namespace enamel::bench {
namespace {

struct Options {
  std::string json;
  std::vector<int> voxels_um = {100, 50, 25};
  uint64_t ticks = 600'000;
  double pause_strokes = measure::AttemptOptions().pause_strokes;
};

constexpr double kFactorGoal = 75, kReachGoal_s = 1;

struct Reach {
  double worst_s = 0, mean_s = 0;
  size_t keyframes = 0, bytes = 0;
};

// Moments spread over the attempt, each as `enamel-station replay --to-tick` reaches it: the
// trace's and the keyframes' bytes are at hand, everything else is timed.
Result<Reach> MeasureReach(const measure::Attempt& attempt, const trace::Keyframes& made) {
  constexpr int kMoments = 20;
  Bytes bytes = made.Encode();
  Reach out{0, 0, made.size(), bytes.size()};
  uint64_t ticks = attempt.seal.ticks;
  for (int i = 1; i <= kMoments; ++i) {
    auto from = std::chrono::steady_clock::now();
    auto keyframes =
        trace::Keyframes::Decode(bytes, HashSha256(trace::EncodeHeader(attempt.header)));
    if (!keyframes.ok()) return keyframes.status();
    trace::MomentOptions options;
    // Not on round numbers: a moment just before a keyframe is as likely as one just behind it.
    options.to_tick = ticks * static_cast<uint64_t>(i) / kMoments - static_cast<uint64_t>(137 * i);
    auto moment = trace::ReplayToMoment(
        [&] { return std::make_unique<core::Core>(attempt.header.params, attempt.built.volume); },
        attempt.header, attempt.chunks, options, *keyframes);
    if (!moment.ok()) return moment.status();
    double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
    out.worst_s = std::max(out.worst_s, s);
    out.mean_s += s / kMoments;
  }
  return out;
}

int Fail(const Status& status) {
  std::fprintf(stderr, "enamel-bench: %s\n", status.message().c_str());
  return 1;
}

int Run(const Options& options) {
  if (!CanWrite(options.json)) return 1;
  std::string method =
      "a class I cavity on the built-in molar, strokes at 2 mm/s with looking in between, recorded "
      "through the core and "
      "encoded as a station sends it; replayed on one core: chunks decoded, chain, every tick's "
      "witness and every "
      "chunk's state hash compared. reach: time to a moment with keyframes, worst of 20 over the "
      "attempt";
  std::printf("Method: %s.\n\n%6s %8s %8s %9s %10s %10s %10s %10s %9s\n", method.c_str(), "voxel",
              "ticks", "cutting", "replay s", "x real", "keyframes", "their MB", "reach s",
              "worst s");
  Rows rows("replay", method);
  std::string goals;
  for (int voxel_um : options.voxels_um) {
    measure::AttemptOptions how;
    how.voxel_nm = voxel_um * 1000;
    how.ticks = options.ticks;
    how.pause_strokes = options.pause_strokes;
    Progress progress;
    auto attempt = measure::RecordAttempt(how, [&](double ratio) {
      progress.Show("recording at " + std::to_string(voxel_um) + " um", ratio);
    });
    if (!attempt.ok()) return Fail(attempt.status());
    trace::Keyframes keyframes(HashSha256(trace::EncodeHeader(attempt->header)));
    trace::MomentOptions whole;
    whole.start_from_keyframe = false;
    auto moment = trace::ReplayToMoment(
        [&] { return std::make_unique<core::Core>(attempt->header.params, attempt->built.volume); },
        attempt->header, attempt->chunks, whole, keyframes,
        [&](double ratio) {
          progress.Show("replaying at " + std::to_string(voxel_um) + " um", ratio);
          return true;
        });
    if (!moment.ok()) return Fail(moment.status());
    if (!moment->report.witness_ok)
      return Fail(Status(Code::kConflict, "the replay disagrees with the recording"));
    auto reach = MeasureReach(*attempt, keyframes);
    if (!reach.ok()) return Fail(reach.status());
    double factor = static_cast<double>(moment->report.ticks) / attempt->header.params.rate_hz /
                    moment->report.seconds;
    progress.Clear();
    std::printf("%6.3f %8llu %6.1f %% %9.2f %10.1f %10zu %10.2f %10.3f %9.3f\n", voxel_um * 1e-3,
                static_cast<unsigned long long>(moment->report.ticks), 100 * attempt->cutting_share,
                moment->report.seconds, factor, reach->keyframes,
                static_cast<double>(reach->bytes) * 1e-6, reach->mean_s, reach->worst_s);
    if (voxel_um == 50) {
      goals = "  replay at 0.05 mm, x real time: " + AgainstGoal(factor, kFactorGoal, true) +
              "\n  worst moment at 0.05 mm: " + AgainstGoal(reach->worst_s, kReachGoal_s) + " s\n";
    }
    rows.Add({{"voxel_mm", voxel_um * 1e-3},
              {"ticks", moment->report.ticks},
              {"cutting_share", attempt->cutting_share},
              {"seconds", moment->report.seconds},
              {"realtime_factor", factor},
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
  auto options = std::make_shared<Options>();
  CLI::App* replay =
      app.add_subcommand("replay", "How fast an attempt is replayed, and a moment of it reached");
  replay->add_option("--voxel-um", options->voxels_um, "Voxel sizes")
      ->delimiter(',')
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  replay->add_option("--ticks", options->ticks, "Length of the attempt at 1 kHz")
      ->check(CLI::Range(20'000, 3'600'000))
      ->capture_default_str();
  replay
      ->add_option("--pause", options->pause_strokes,
                   "Looking after each stroke, in strokes: decides the share of ticks that cut")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  replay->add_option("--json", options->json, "Write the rows to this file");
  replay->callback([options, exit_code] { *exit_code = Run(*options); });
}

}  // namespace enamel::bench
