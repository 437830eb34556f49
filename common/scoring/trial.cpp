#include "common/scoring/trial.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "common/scene/preparation.h"
#include "common/scene/prepared_target.h"

namespace enamel::scoring {
namespace {

// Of the work: an untouched surface is far from the exact cut, and distances take the longer.
constexpr double kExactShare = 0.2;

// What only a hand that cuts can show is not asked for.
void LeaveOutTheHand(MetricSet& metrics) {
  for (MissingMetric& missing : metrics.missing) {
    if (!IsSeenOnTheTooth(missing.name)) missing.why = NoValue::kNotInTask;
  }
}

Result<ScoreResult> Judge(const scene::Rubric& rubric, MetricSet metrics, const AcceptableCut& r,
                          const cutting::Volume& final_volume) {
  ENAMEL_RETURN_IF_ERROR(CheckCriticalIsMeasured(rubric, metrics));
  LeaveOutTheHand(metrics);
  ENAMEL_ASSIGN_OR_RETURN(JudgedCut cut, JudgeCut(r, final_volume, rubric));
  return ApplyRubric(rubric, metrics, std::move(cut.measures), std::move(cut.found.mistakes));
}

}  // namespace

Result<cutting::Volume> ExactCut(const scene::Scene& scene, const scene::Exercise& exercise,
                                 const cutting::Volume& initial) {
  if (const auto& tooth = exercise.target.prepared_tooth) return tooth->volume;
  ENAMEL_ASSIGN_OR_RETURN(const auto shape, scene::TargetShape(scene, exercise.target));
  return scene::Prepared(initial, shape, scene::Neighbours::kSpared);
}

std::vector<LostItem> LostItems(const ScoreResult& score) {
  std::vector<LostItem> out;
  for (size_t i = 0; i < score.costs.size(); ++i) {
    if (score.costs[i].lost > 0) out.push_back({score.measures[i].name, score.costs[i].lost});
  }
  for (const CriterionResult& c : score.criteria) {
    if (c.group == Group::kHand && c.lost > 0) out.push_back({c.name, c.lost});
  }
  std::ranges::stable_sort(out, std::greater<>(), &LostItem::points);
  return out;
}

ProcessRecorder CalmRecording() {
  const core::CoreParams params;
  ProcessRecorder recorder(params);
  for (int i = 0; i < static_cast<int>(params.rate_hz); ++i) {
    trace::Tick tick;
    tick.witness.anchor_100nm[0] = 10 * i;  // 1 mm/s
    tick.witness.force_computed_mn[2] = 1000;
    recorder.AddRecorded(tick);
  }
  return recorder;
}

CalmAttempts::CalmAttempts(const cutting::Volume& initial, cutting::Volume exact)
    : initial_(initial),
      exact_(std::move(exact)),
      exact_mesh_(surface::ExtractSurface(exact_)),
      process_(CalmRecording()) {}

Result<MetricSet> CalmAttempts::Measure(const scene::Scene& scene, const scene::Exercise& exercise,
                                        const cutting::Volume& final_volume,
                                        const std::function<bool(double)>& progress,
                                        const MetricPlan& plan) const {
  const surface::Mesh mesh = surface::ExtractSurface(final_volume);
  return ComputeMetrics(scene, exercise, {&initial_, &final_volume, &mesh, &process_},
                        {&initial_, &exact_, &exact_mesh_, &process_}, progress, plan);
}

Result<Trial> TryExercise(const scene::Scene& scene, const scene::Exercise& exercise,
                          const cutting::Volume& initial,
                          const std::function<bool(double)>& progress) {
  auto from = [&](double begin, double part) {
    return [&progress, begin, part](double done) {
      return !progress || progress(begin + part * done);
    };
  };
  if (!from(0, 0)(0)) return Status(Code::kUnavailable, "the trial was ended");
  ENAMEL_ASSIGN_OR_RETURN(auto exact, ExactCut(scene, exercise, initial));
  const CalmAttempts attempts(initial, std::move(exact));
  const MetricPlan plan = MetricPlan::For(exercise.rubric);
  Trial out;
  const AcceptableCut r(initial, attempts.exact(), {scene.tooth, scene.up});
  ENAMEL_ASSIGN_OR_RETURN(
      auto cut, attempts.Measure(scene, exercise, attempts.exact(), from(0, kExactShare), plan));
  ENAMEL_ASSIGN_OR_RETURN(out.exact, Judge(exercise.rubric, std::move(cut), r, attempts.exact()));
  ENAMEL_ASSIGN_OR_RETURN(auto left, attempts.Measure(scene, exercise, initial,
                                                      from(kExactShare, 1 - kExactShare), plan));
  ENAMEL_ASSIGN_OR_RETURN(out.untouched, Judge(exercise.rubric, std::move(left), r, initial));
  return out;
}

}  // namespace enamel::scoring
