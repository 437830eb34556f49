#include "common/scoring/trial.h"

#include <algorithm>
#include <utility>

#include "common/scene/preparation.h"
#include "common/scene/prepared_target.h"

namespace enamel::scoring {
namespace {

constexpr double kExact = 1e-6;  // points: the rounding of their sums
// Of the work: an untouched surface is far from the exact cut, and distances take the longer.
constexpr double kExactShare = 0.2;

Result<cutting::Volume> ExactCut(const scene::Scene& scene, const scene::Exercise& exercise,
                                 const cutting::Volume& initial) {
  if (const auto& tooth = exercise.target.prepared_tooth) return tooth->volume;
  ENAMEL_ASSIGN_OR_RETURN(const auto shape, scene::TargetShape(scene, exercise.target));
  return scene::Prepared(initial, shape, scene::Neighbours::kSpared);
}

// What only a hand that cuts can show is not asked for.
void LeaveOutTheHand(MetricSet& metrics) {
  for (MissingMetric& missing : metrics.missing) {
    if (!IsSeenOnTheTooth(missing.name)) missing.why = NoValue::kNotInTask;
  }
}

bool HasValue(const MetricSet& metrics, const std::string& name) {
  return std::ranges::find(metrics.values, name, &MetricValue::name) != metrics.values.end();
}

Result<ScoreResult> Judge(scene::Rubric rubric, MetricSet metrics) {
  ENAMEL_RETURN_IF_ERROR(CheckCriticalIsMeasured(rubric, metrics));
  LeaveOutTheHand(metrics);
  std::erase_if(rubric.gates, [&](const scene::RubricGate& gate) {
    return !IsSeenOnTheTooth(gate.metric) && !HasValue(metrics, gate.metric);
  });
  return ApplyRubric(rubric, metrics);
}

std::vector<Trial::Item> Lost(const scene::Rubric& rubric, const ScoreResult& score) {
  double left = 1;
  std::vector<Trial::Item> all, out;
  for (const GateResult& gate : score.gates) {
    left *= gate.share;
    all.push_back({gate.name, gate.title, gate.share});
  }
  for (const CriterionResult& c : score.criteria) {
    const double most = c.max_points * left;
    if (c.max_points > 0) all.push_back({c.name, c.title, most > 0 ? c.points / most : 0});
  }
  // Where two criteria judge one metric: the one that lost more.
  for (const std::string& metric : CostlyCriteria(rubric, score)) {
    const auto worst = std::ranges::min_element(
        all, {}, [&](const Trial::Item& item) { return item.metric == metric ? item.share : 2; });
    out.push_back(*worst);
  }
  return out;
}

std::vector<Trial::Item> FullMarks(const ScoreResult& score) {
  std::vector<Trial::Item> out;
  for (const CriterionResult& c : score.criteria) {
    if (c.judged && c.max_points > 0 && c.points >= c.max_points - kExact)
      out.push_back({c.name, c.title, 1});
  }
  return out;
}

}  // namespace

ProcessRecorder CalmRecording() {
  const core::CoreParams params;
  ProcessRecorder recorder(params);
  for (int i = 0; i < static_cast<int>(params.rate_hz); ++i) {
    trace::Tick tick;
    tick.witness.anchor_100nm[0] = 10 * i;  // 1 mm/s
    tick.witness.force_sent_mn[2] = 1000;
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
  ENAMEL_ASSIGN_OR_RETURN(
      auto cut, attempts.Measure(scene, exercise, attempts.exact(), from(0, kExactShare), plan));
  ENAMEL_ASSIGN_OR_RETURN(out.exact, Judge(exercise.rubric, std::move(cut)));
  ENAMEL_ASSIGN_OR_RETURN(auto left, attempts.Measure(scene, exercise, initial,
                                                      from(kExactShare, 1 - kExactShare), plan));
  ENAMEL_ASSIGN_OR_RETURN(out.untouched, Judge(exercise.rubric, std::move(left)));
  out.lost_by_exact = Lost(exercise.rubric, out.exact);
  out.full_untouched = FullMarks(out.untouched);
  return out;
}

}  // namespace enamel::scoring
