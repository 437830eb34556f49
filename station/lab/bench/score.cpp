#include "common/scoring/score.h"

#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "common/program/example.h"
#include "common/program/log.h"
#include "common/scoring/envelope.h"
#include "common/scoring/metrics.h"
#include "common/scoring/movement/provenance.h"
#include "common/trace/replay.h"
#include "station/lab/bench/bench.h"
#include "station/lab/cutting/attempt.h"

// Time to verify and score an attempt, step by step, as in the server's score job.
namespace enamel::station::lab::bench {
namespace {

// Of this thread alone: other programs count only as far as they share its caches.
double ScoreClock_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct ScoreOptions {
  std::string json;
  std::vector<int> voxels_um = {50};
  uint64_t ticks = 600'000;
  int repeats = 3;
};

constexpr int kReferences = 3;
constexpr double kTotalGoal_s = 3, kProvenanceGoal_percent = 10, kVoxelGoal_bytes = 2;
// The attempt's faults, so that the score has work to do.
constexpr double kMesialExtra_m = 0.3e-3, kFloorExtra_m = 0.2e-3;
// A dentist's cut differs from the next one's by so much.
constexpr double kBetweenReferences_m = 0.05e-3;

// The minimum of several runs.
class Least {
 public:
  void Take(double from_s) {
    const double s = ScoreClock_s() - from_s;
    s_ = s_ < 0 ? s : std::min(s_, s);
  }
  double s() const { return s_; }

 private:
  double s_ = -1;
};

struct ScoreFigures {
  Least verify, replay, replay_with_provenance, measure, measure_all, judge, deductions, encode;
  size_t removed_voxels = 0, blob_bytes = 0;
  double Total_s() const {
    return verify.s() + replay_with_provenance.s() + measure_all.s() + deductions.s() + encode.s();
  }
  // With several references, as the server does it: by the exercise's plan.
  double WithReferences_s() const {
    return verify.s() + replay_with_provenance.s() + judge.s() + deductions.s() + encode.s();
  }
  double ProvenanceShare_percent() const {
    return 100 * (replay_with_provenance.s() / replay.s() - 1);
  }
  double BytesPerVoxel() const {
    return removed_voxels == 0
               ? 0
               : static_cast<double>(blob_bytes) / static_cast<double>(removed_voxels);
  }
};

// The replayed attempt and the data gathered from it.
struct Replayed {
  std::unique_ptr<core::Core> core;
  std::unique_ptr<scoring::ProcessRecorder> process;
  std::unique_ptr<scoring::ProvenanceRecorder> provenance;  // where it was asked for
  surface::Mesh mesh;

  scoring::AttemptData Data(const Attempt& attempt) const {
    return {&attempt.built.volume, &core->volume(), &mesh, process.get(), nullptr};
  }
};

Result<Replayed> ReplayScored(const Attempt& attempt, bool provenance, Least& time) {
  Replayed out;
  const core::CoreParams& params = attempt.header.params;
  out.core = std::make_unique<core::Core>(params, attempt.built.volume);
  out.process = std::make_unique<scoring::ProcessRecorder>(params);
  const double from = ScoreClock_s();
  if (provenance) {
    out.provenance = std::make_unique<scoring::ProvenanceRecorder>(attempt.built.volume);
  }
  auto report = trace::Replay(*out.core, attempt.header, attempt.chunks,
                              [&](const trace::Tick& tick, const core::TickOutput& output) {
                                out.process->Add(tick, output);
                                if (out.provenance) {
                                  out.provenance->Add(out.core->volume(), out.core->touched());
                                }
                              });
  time.Take(from);
  ENAMEL_RETURN_IF_ERROR(report.status());
  if (!report->witness_ok || report->state_hash != attempt.seal.state_hash) {
    return Status(Code::kConflict, "the replay disagrees with the recording");
  }
  return out;
}

Status Verify(const Attempt& attempt) {
  // Not the recording's key: a signature that fails costs as much to check as one that fits.
  const trace::PublicKey key{};
  trace::ChainVerifier chain(attempt.header.ticket.attempt,
                             HashSha256(trace::EncodeHeader(attempt.header)));
  for (const Bytes& bytes : attempt.chunks) {
    trace::VerifyChunk(bytes, key);
    ENAMEL_ASSIGN_OR_RETURN(auto chunk, trace::DecodeChunkHead(bytes));
    ENAMEL_RETURN_IF_ERROR(chain.Accept(chunk));
  }
  return chain.AcceptSeal(attempt.seal);
}

// A reference's cut divides the tooth into regions once.
struct Reference {
  Attempt attempt;
  Replayed cut;
  std::unique_ptr<scoring::AcceptableCut> r;
};

using References = std::vector<std::unique_ptr<Reference>>;

struct Scored {
  scoring::JudgedCut judged;
  scoring::ScoreResult score;
};

// Surface, metrics, regions, mistakes, points.
Result<Scored> MeasureScore(const Attempt& attempt, const Reference& reference, Replayed& replayed,
                            const scoring::MetricPlan& plan) {
  replayed.mesh = surface::ExtractSurface(replayed.core->volume());
  ENAMEL_ASSIGN_OR_RETURN(
      const auto metrics,
      scoring::ComputeMetrics(attempt.built.scene, attempt.exercise, replayed.Data(attempt),
                              reference.cut.Data(reference.attempt), {}, plan));
  Scored out;
  const scene::Rubric& rubric = attempt.exercise.rubric;
  ENAMEL_ASSIGN_OR_RETURN(out.judged,
                          scoring::JudgeCut(*reference.r, replayed.core->volume(), rubric));
  ENAMEL_ASSIGN_OR_RETURN(out.score, scoring::ApplyRubric(rubric, metrics, out.judged.measures,
                                                          out.judged.found.mistakes));
  return out;
}

// Measured against every reference, and placed among them by what those are against the first: the
// server keeps that.
Status JudgeByAll(const Attempt& attempt, const References& references,
                  const std::vector<scoring::MetricSet>& among, Replayed& replayed, Least& time) {
  const auto plan = scoring::MetricPlan::For(attempt.exercise.rubric);
  const double from = ScoreClock_s();
  replayed.mesh = surface::ExtractSurface(replayed.core->volume());
  std::optional<scoring::MetricSet> first;
  for (const auto& reference : references) {
    ENAMEL_ASSIGN_OR_RETURN(
        auto metrics,
        scoring::ComputeMetrics(attempt.built.scene, attempt.exercise, replayed.Data(attempt),
                                reference->cut.Data(reference->attempt), {}, plan));
    const scene::Rubric& rubric = attempt.exercise.rubric;
    ENAMEL_ASSIGN_OR_RETURN(auto judged,
                            scoring::JudgeCut(*reference->r, replayed.core->volume(), rubric));
    ENAMEL_ASSIGN_OR_RETURN(auto score,
                            scoring::ApplyRubric(rubric, metrics, std::move(judged.measures),
                                                 std::move(judged.found.mistakes)));
    if (!first) first = std::move(metrics);
  }
  if (references.size() > 1) {
    std::vector<scoring::EnvelopeMember> members;
    for (size_t i = 0; i < references.size(); ++i) {
      members.push_back({std::to_string(i), &references[i]->cut.core->volume(), among[i]});
    }
    ENAMEL_ASSIGN_OR_RETURN(
        auto envelope,
        scoring::PlaceInEnvelope(attempt.built.volume, replayed.core->volume(), *first, members));
  }
  time.Take(from);
  return Status::Ok();
}

Status MeasureOnce(const Attempt& attempt, const References& references,
                   const std::vector<scoring::MetricSet>& among, ScoreFigures& out) {
  const Reference& reference = *references.front();
  double from = ScoreClock_s();
  ENAMEL_RETURN_IF_ERROR(Verify(attempt));
  out.verify.Take(from);
  // Alternately, so that a machine that slows down affects both.
  ENAMEL_ASSIGN_OR_RETURN(auto without, ReplayScored(attempt, false, out.replay));
  ENAMEL_ASSIGN_OR_RETURN(auto replayed, ReplayScored(attempt, true, out.replay_with_provenance));

  from = ScoreClock_s();
  ENAMEL_ASSIGN_OR_RETURN(auto planned,
                          MeasureScore(attempt, reference, replayed,
                                       scoring::MetricPlan::For(attempt.exercise.rubric)));
  out.measure.Take(from);

  from = ScoreClock_s();
  ENAMEL_ASSIGN_OR_RETURN(auto scored,
                          MeasureScore(attempt, reference, replayed, scoring::MetricPlan::All()));
  out.measure_all.Take(from);

  ENAMEL_RETURN_IF_ERROR(JudgeByAll(attempt, references, among, replayed, out.judge));

  from = ScoreClock_s();
  const scoring::Provenance provenance = replayed.provenance->Take();
  scored.score.deductions =
      scoring::FindDeductions({reference.r.get(), &replayed.core->volume(), &scored.judged.found,
                               &provenance, &replayed.process->strokes()});
  out.deductions.Take(from);

  from = ScoreClock_s();
  const Bytes blob = scoring::EncodeProvenance(provenance);
  out.encode.Take(from);
  out.removed_voxels = provenance.tick.size();
  out.blob_bytes = blob.size();
  return Status::Ok();
}

Result<ScoreFigures> MeasureScoreAt(int voxel_um, const ScoreOptions& options, Progress& progress) {
  const std::string at = " at " + std::to_string(voxel_um) + " um";
  AttemptOptions how;
  how.voxel_nm = voxel_um * 1000;
  how.ticks = options.ticks;
  References references;
  std::vector<scoring::MetricSet> among;
  Least unused;
  for (int i = 0; i < kReferences; ++i) {
    how.mesial_extra_m = how.floor_extra_m = i * kBetweenReferences_m;
    ENAMEL_ASSIGN_OR_RETURN(auto recorded, RecordAttempt(how, [&](double ratio) {
                              progress.Show("reference" + at, ratio);
                            }));
    ENAMEL_ASSIGN_OR_RETURN(auto cut, ReplayScored(recorded, false, unused));
    cut.mesh = surface::ExtractSurface(cut.core->volume());
    // On the heap: its volumes are kept, not copied.
    auto reference = std::make_unique<Reference>(std::move(recorded), std::move(cut));
    const scene::BuiltScene& built = reference->attempt.built;
    reference->r = std::make_unique<scoring::AcceptableCut>(
        built.volume, reference->cut.core->volume(),
        scoring::ToothPlace{built.scene.tooth, built.scene.up});
    references.push_back(std::move(reference));
  }
  for (const auto& reference : references) {
    const Attempt& first = references.front()->attempt;
    ENAMEL_ASSIGN_OR_RETURN(
        among.emplace_back(),
        scoring::ComputeMetrics(first.built.scene, first.exercise, reference->cut.Data(first),
                                references.front()->cut.Data(first), {},
                                scoring::MetricPlan::For(first.exercise.rubric)));
  }
  how.mesial_extra_m = kMesialExtra_m;
  how.floor_extra_m = kFloorExtra_m;
  ENAMEL_ASSIGN_OR_RETURN(auto attempt, RecordAttempt(how, [&](double ratio) {
                            progress.Show("attempt" + at, ratio);
                          }));
  ScoreFigures out;
  for (int r = 0; r < options.repeats; ++r) {
    progress.Show("scoring" + at, static_cast<double>(r) / options.repeats);
    ENAMEL_RETURN_IF_ERROR(MeasureOnce(attempt, references, among, out));
  }
  return out;
}

int RunScore(const ScoreOptions& options) {
  if (!CanWrite(options.json)) return 1;
  const std::string method =
      "a class I cavity on the built-in molar, its mesial wall 0.3 mm and its floor 0.2 mm too "
      "deep, "
      "recorded through the core, against one cut as asked for; on one core: signatures and chain "
      "of "
      "every chunk, replay with process metrics, without and with provenance in turn, surface, "
      "metrics, regions, mistakes and points, by the exercise's plan and all there are, by the "
      "plan "
      "against all "
      "references with their envelope, deductions, provenance packed; "
      "total: with all metrics; seconds of the thread: the least of several runs";
  std::printf("Method: %s.\n\n%6s %8s %9s %9s %9s %9s %9s %9s %9s %9s %9s %9s %9s\n",
              method.c_str(), "voxel", "ticks", "verify s", "replay s", "with it", "by plan s",
              "all s", "refs s", "lost s", "pack s", "total s", "voxels", "B/voxel");
  Rows rows("score", method);
  std::string goals;
  for (int voxel_um : options.voxels_um) {
    Progress progress;
    auto f = MeasureScoreAt(voxel_um, options, progress);
    if (!f.ok()) {
      program::SayError(f.status().message());
      return 1;
    }
    progress.Clear();
    std::printf("%6.3f %8llu %9.3f %9.3f %9.3f %9.3f %9.3f %9.3f %9.3f %9.3f %9.3f %9zu %9.2f\n",
                voxel_um * 1e-3, static_cast<unsigned long long>(options.ticks), f->verify.s(),
                f->replay.s(), f->replay_with_provenance.s(), f->measure.s(), f->measure_all.s(),
                f->judge.s(), f->deductions.s(), f->encode.s(), f->Total_s(), f->removed_voxels,
                f->BytesPerVoxel());
    if (voxel_um == 50) {
      goals = "  verified and scored at 0.05 mm, s: " + AgainstGoal(f->Total_s(), kTotalGoal_s) +
              "\n  the same with " + std::to_string(kReferences) +
              " references, s: " + AgainstGoal(f->WithReferences_s(), kTotalGoal_s) +
              "\n  provenance, % of the replay: " +
              AgainstGoal(f->ProvenanceShare_percent(), kProvenanceGoal_percent) +
              "\n  provenance, bytes per removed voxel: " +
              AgainstGoal(f->BytesPerVoxel(), kVoxelGoal_bytes) + "\n";
    }
    rows.Add({{"voxel_mm", voxel_um * 1e-3},
              {"ticks", options.ticks},
              {"verify_s", f->verify.s()},
              {"replay_s", f->replay.s()},
              {"replay_with_provenance_s", f->replay_with_provenance.s()},
              {"provenance_share_percent", f->ProvenanceShare_percent()},
              {"measure_s", f->measure.s()},
              {"measure_all_s", f->measure_all.s()},
              {"references", kReferences},
              {"references_s", f->judge.s()},
              {"deductions_s", f->deductions.s()},
              {"pack_s", f->encode.s()},
              {"total_s", f->Total_s()},
              {"removed_voxels", f->removed_voxels},
              {"provenance_bytes", f->blob_bytes},
              {"bytes_per_voxel", f->BytesPerVoxel()}});
  }
  if (!goals.empty()) std::printf("\nGoals:\n%s", goals.c_str());
  return rows.Write(options.json);
}

}  // namespace

void RegisterScore(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<ScoreOptions>();
  CLI::App* score =
      app.add_subcommand("score", "What verifying and scoring an attempt takes, step by step");
  score->add_option("--voxel-um", options->voxels_um, "Voxel sizes")
      ->delimiter(',')
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  score->add_option("--ticks", options->ticks, "Length of the attempt at 1 kHz")
      ->check(CLI::Range(20'000, 3'600'000))
      ->capture_default_str();
  score->add_option("--repeats", options->repeats, "Identical runs")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  score->add_option("--json", options->json, "Write the rows to this file");
  program::AddExamples(*score, {"--voxel-um 50"});
  score->callback([options, exit_code] { *exit_code = RunScore(*options); });
}

}  // namespace enamel::station::lab::bench
