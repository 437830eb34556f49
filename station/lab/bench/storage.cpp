#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>

#include "common/base/packed.h"
#include "common/program/example.h"
#include "common/program/log.h"
#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"
#include "common/scoring/deviation.h"
#include "common/scoring/movement/motion.h"
#include "common/scoring/movement/series.h"
#include "common/scoring/score.h"
#include "common/timeline/deviation.h"
#include "common/timeline/recorder.h"
#include "station/devices/operators.h"
#include "station/lab/bench/bench.h"
#include "station/lab/grades/operator_run.h"

// What a server keeps of an attempt, by parts, over the exercises that a school does.
namespace enamel::station::lab::bench {
namespace {

struct StorageOptions {
  std::string json, hand = "student";
  int voxel_um = 50;
  bool quick = false;
};

constexpr double kAttemptGoal_mb = 2.3, kYearGoal_gb = 28, kTimelineGoal_mb = 0.5,
                 kDeviationGoal_mb = 0.2, kVolumeGoal_mb = 0.3;
constexpr int kAttemptsAYear = 12'000;
constexpr uint64_t kMaxTicks = 3'000'000;
constexpr size_t kChunkTicks = 500;

// What the attempts of a school are of: of 51, so many of each kind, over its exercises alike.
struct Kind {
  const char* name;
  int share;
  std::vector<std::pair<const char*, const char*>> exercises;  // scene, name
};
const Kind kMix[] = {
    {"class I", 9, {{"molar", "class-1-molar-46"}, {"premolar", "class-1-premolar-14"}}},
    {"class V", 2, {{"molar-buccal", "class-5-molar-46-buccal"}}},
    {"access", 3, {{"molar", "access-molar-46"}}},
    {"caries", 3, {{"molar-caries", "caries-molar-46-caries"}}},
    {"veneer", 2, {{"incisor-labial", "veneer-incisor-11-labial"}}},
    {"crown",
     11,
     {{"molar", "crown-molar-46"},
      {"premolar", "crown-premolar-14"},
      {"incisor", "crown-incisor-11"}}},
    {"block", 15, {{"block", "circle-block"}, {"block", "step-block"}}},
    {"class II", 6, {{"molar-class-2", "class-2-molar-46-class-2"}}},
};

struct Parts {
  double minutes = 0;
  size_t trace = 0, series = 0, timeline = 0, deviation = 0, volume = 0, score = 0;
  size_t all() const { return trace + series + timeline + deviation + volume + score; }
};

double Mb(size_t bytes) { return static_cast<double>(bytes) * 1e-6; }

struct Cut {
  core::CoreParams params;
  std::vector<trace::Tick> ticks;
  cutting::Volume volume;
  surface::Mesh mesh;
  std::vector<ivec3> cells;
  std::optional<scoring::ProcessRecorder> process;

  scoring::AttemptData Data(const cutting::Volume& initial) const {
    return {&initial, &volume, &mesh, &*process, nullptr};
  }
};

Result<Cut> CutBy(const char* who, const scene::BuiltScene& built, const scene::Exercise& exercise,
                  const scene::DeviceProfile& profile) {
  const OperatorPreset* preset = FindOperator(who);
  ENAMEL_CHECK(preset != nullptr);
  Cut out;
  ENAMEL_ASSIGN_OR_RETURN(out.volume,
                          RunOperator(*preset, built, exercise, profile, 0, kMaxTicks,
                                      [&](const core::CoreParams& params, const trace::Tick& tick) {
                                        if (!out.process) out.process.emplace(params);
                                        out.params = params;
                                        out.process->AddRecorded(tick);
                                        out.ticks.push_back(tick);
                                      }));
  out.mesh = surface::ExtractSurface(out.volume, &out.cells);
  return out;
}

size_t TraceBytes(const Cut& cut) {
  std::array<uint8_t, 32> seed{};
  const trace::KeyPair key = trace::KeyPairFromSeed(seed);
  size_t out = 0;
  trace::ChunkHead head;
  for (size_t from = 0; from < cut.ticks.size(); from += kChunkTicks) {
    const size_t count = std::min(kChunkTicks, cut.ticks.size() - from);
    head.first_tick = from;
    out += trace::EncodeChunk(head, {cut.ticks.data() + from, count}, key.secret_key).size();
    ++head.seq;
  }
  return out;
}

// As a server packs text before it encrypts it (schemas/personal_data.md, "Envelope").
size_t PackedBytes(const std::string& text) { return Pack(AsBytes(text), kTextLevel).size(); }

// What the replay leaves: curves over time and the surface timeline.
void ReplayStored(const Cut& cut, const cutting::Volume& initial,
                  const timeline::Deviation& deviation, Parts& out) {
  timeline::RecorderOptions options;
  options.rate_hz = cut.params.rate_hz;
  options.ticks = cut.ticks.size();
  options.burs = core::BursOf(cut.params);
  options.frame_ticks = std::max(1u, cut.params.rate_hz / 10);
  for (const timeline::CellDeviation& value : deviation.cells) {
    options.detailed.push_back(initial.spec().BrickIndex(value.cell / cutting::kBrickSide));
  }
  std::ranges::sort(options.detailed);
  options.detailed.erase(std::unique(options.detailed.begin(), options.detailed.end()),
                         options.detailed.end());
  timeline::Recorder recorder(initial, {}, options);
  scoring::SeriesRecorder series(cut.params, initial.spec().voxel_m(), cut.ticks.size());
  core::Core core(cut.params, initial);
  uint64_t passed = 0;
  for (const trace::Tick& tick : cut.ticks) {
    const core::TickOutput output = core.Step(tick.input);
    recorder.Add(core.volume(), core.touched(),
                 {output.anchor, (tick.input.flags & core::kBurOn) != 0, tick.input.gap_ticks});
    series.Add(tick, output);
    passed += 1 + tick.input.gap_ticks;
  }
  ENAMEL_CHECK(core.volume() == cut.volume);
  out.minutes = static_cast<double>(passed) / cut.params.rate_hz / 60;
  out.timeline = recorder.Finish(core.volume()).size();
  out.series = PackedBytes(series.ToJson());
}

Result<Parts> MeasureOne(const char* scene_name, const char* name, const StorageOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(const auto built,
                          scene::BuildBuiltinScene(scene_name, options.voxel_um * 1000));
  const auto exercises =
      scene::BuiltinExercises(built.scene, HashSha256(AsBytes(scene::ToJson(built.scene))));
  const auto exercise = std::ranges::find(exercises, name, &scene::Exercise::name);
  ENAMEL_CHECK(exercise != exercises.end());
  const auto profiles = scene::BuiltinProfiles();
  const auto profile = std::ranges::find(profiles, "phantom_desktop", &scene::DeviceProfile::name);
  ENAMEL_CHECK(profile != profiles.end());
  ENAMEL_ASSIGN_OR_RETURN(const Cut reference, CutBy("dentist", built, *exercise, *profile));
  ENAMEL_ASSIGN_OR_RETURN(const Cut cut, CutBy(options.hand.c_str(), built, *exercise, *profile));
  const std::vector<float> deviation_m = scoring::DeviationPerVertex(
      cut.mesh, built.volume, cut.volume, reference.volume, reference.mesh);
  const auto deviation = timeline::DeviationOf(cut.volume.spec(), cut.cells, deviation_m);
  Parts out;
  out.trace = TraceBytes(cut);
  out.deviation = timeline::EncodeDeviation(deviation).size();
  out.volume = scene::EncodeChange(cut.volume, built.volume, built.scene.volume).size();
  ReplayStored(cut, built.volume, deviation, out);
  ENAMEL_ASSIGN_OR_RETURN(auto metrics,
                          scoring::ComputeMetrics(built.scene, *exercise, cut.Data(built.volume),
                                                  reference.Data(built.volume)));
  const scoring::AcceptableCut r(built.volume, reference.volume,
                                 {built.scene.tooth, built.scene.up});
  ENAMEL_ASSIGN_OR_RETURN(auto judged, scoring::JudgeCut(r, cut.volume, exercise->rubric));
  ENAMEL_ASSIGN_OR_RETURN(
      const auto score, scoring::ApplyRubric(exercise->rubric, metrics, std::move(judged.measures),
                                             std::move(judged.found.mistakes)));
  out.score = PackedBytes(scoring::ToJson(score));
  if (const auto motion = scoring::MotionOf(cut.process->samples())) {
    out.score += scoring::EncodeMotion(*motion).size();
  }
  return out;
}

int RunStorage(const StorageOptions& options) {
  if (!CanWrite(options.json)) return 1;
  const std::string method =
      "each exercise cut by the simulated " + options.hand +
      " on a Phantom Desktop, compared with the "
      "simulated "
      "dentist's cut; bytes before encryption, as a server stores them; means weighted by a "
      "school's attempts (of 51: class I 9, class V 2, access 3, caries 3, veneer 2, crown 11, "
      "block 15, class II 6). Curves and score are packed. Score without the places of its "
      "mistakes, and the motion, are in `score`";
  std::printf("Method: %s.\n\n%-9s %-26s %6s %8s %8s %9s %10s %8s %8s %8s\n", method.c_str(),
              "kind", "exercise", "min", "trace", "series", "timeline", "deviation", "volume",
              "score", "MB");
  Rows rows("storage", method);
  double shares = 0;
  std::array<double, 6> mean{};
  double minutes = 0;
  for (const Kind& kind : kMix) {
    const size_t count = options.quick ? 1 : kind.exercises.size();
    for (size_t i = 0; i < count; ++i) {
      const auto& [scene_name, name] = kind.exercises[i];
      Progress progress;
      progress.Show(name, shares / 51);
      const auto parts = MeasureOne(scene_name, name, options);
      progress.Clear();
      if (!parts.ok()) {
        program::SayError(std::string(name) + ": " + parts.status().message());
        return 1;
      }
      const std::array<size_t, 6> of = {parts->trace,     parts->series, parts->timeline,
                                        parts->deviation, parts->volume, parts->score};
      const double share = static_cast<double>(kind.share) / static_cast<double>(count);
      shares += share;
      minutes += share * parts->minutes;
      for (size_t k = 0; k < of.size(); ++k) mean[k] += share * Mb(of[k]);
      std::printf("%-9s %-26s %6.1f %8.3f %8.3f %9.3f %10.3f %8.3f %8.3f %8.3f\n", kind.name, name,
                  parts->minutes, Mb(of[0]), Mb(of[1]), Mb(of[2]), Mb(of[3]), Mb(of[4]), Mb(of[5]),
                  Mb(parts->all()));
      std::fflush(stdout);
      rows.Add({{"kind", kind.name},
                {"exercise", name},
                {"share", share / 51},
                {"minutes", parts->minutes},
                {"trace_mb", Mb(of[0])},
                {"series_mb", Mb(of[1])},
                {"timeline_mb", Mb(of[2])},
                {"deviation_mb", Mb(of[3])},
                {"volume_mb", Mb(of[4])},
                {"score_mb", Mb(of[5])},
                {"stored_mb", Mb(parts->all())}});
    }
  }
  double all = 0;
  for (double& part : mean) all += part /= shares;
  minutes /= shares;
  std::printf("%-36s %6.1f %8.3f %8.3f %9.3f %10.3f %8.3f %8.3f %8.3f\n", "mean of the mix",
              minutes, mean[0], mean[1], mean[2], mean[3], mean[4], mean[5], all);
  const double year_gb = all * kAttemptsAYear * 1e-3;
  rows.Add({{"kind", "mean"},
            {"exercise", ""},
            {"share", 1},
            {"minutes", minutes},
            {"trace_mb", mean[0]},
            {"series_mb", mean[1]},
            {"timeline_mb", mean[2]},
            {"deviation_mb", mean[3]},
            {"volume_mb", mean[4]},
            {"score_mb", mean[5]},
            {"stored_mb", all},
            {"year_gb", year_gb}});
  std::printf("\nGoals:\n  stored per attempt, MB: %s\n",
              AgainstGoal(all, kAttemptGoal_mb).c_str());
  std::printf("  a year of %d, GB: %s\n", kAttemptsAYear,
              AgainstGoal(year_gb, kYearGoal_gb).c_str());
  std::printf("  timeline, MB: %s\n", AgainstGoal(mean[2], kTimelineGoal_mb).c_str());
  std::printf("  deviation, MB: %s\n", AgainstGoal(mean[3], kDeviationGoal_mb).c_str());
  std::printf("  volume, MB: %s\n", AgainstGoal(mean[4], kVolumeGoal_mb).c_str());
  return rows.Write(options.json);
}

}  // namespace

void RegisterStorage(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<StorageOptions>();
  CLI::App* storage = app.add_subcommand(
      "storage", "Megabytes a server keeps of an attempt, by parts, and of a school's year");
  storage->add_option("--voxel-um", options->voxel_um, "Voxel size")
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  storage->add_option("--operator", options->hand, "Whose attempts: a simulated person")
      ->check([](const std::string& name) {
        return FindOperator(name) != nullptr ? "" : "no simulated person has that name";
      })
      ->capture_default_str();
  storage->add_flag("--quick", options->quick, "One exercise of each kind");
  storage->add_option("--json", options->json, "Write the rows to this file");
  program::AddExamples(*storage, {"--quick"});
  storage->callback([options, exit_code] { *exit_code = RunStorage(*options); });
}

}  // namespace enamel::station::lab::bench
