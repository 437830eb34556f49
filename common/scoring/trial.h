#pragma once

#include <functional>
#include <vector>

#include "common/scoring/score.h"

// What a rubric makes of attempts that no hand made: teeth given as volumes, judged against the
// target cut exactly. Deterministic. Thread safety: const after construction.
namespace enamel::scoring {

// A second of a bur moved with 1 N: meets a rubric's demands on the hand, and gives no other
// information.
ProcessRecorder CalmRecording();

// Measures volumes as if a calm hand had cut them within the time.
class CalmAttempts {
 public:
  // `initial` is kept, not copied; `exact` is what attempts are compared with. Requires: equal
  // grids.
  CalmAttempts(const cutting::Volume& initial, cutting::Volume exact);

  const cutting::Volume& exact() const { return exact_; }
  // Errors: those of ComputeMetrics.
  Result<MetricSet> Measure(const scene::Scene& scene, const scene::Exercise& exercise,
                            const cutting::Volume& final_volume,
                            const std::function<bool(double)>& progress = {},
                            const MetricPlan& plan = MetricPlan::All()) const;

 private:
  const cutting::Volume& initial_;
  cutting::Volume exact_;
  surface::Mesh exact_mesh_;
  ProcessRecorder process_;
};

// The two attempts that show whether a rubric is right: the target cut exactly has to cost nothing, and a tooth that
// nobody touched everything. Of the hand's figures those count that a calm recording has: nobody moved a bur for these.
struct Trial {
  ScoreResult exact, untouched;
};

// What cost points: regions, kinds of damage, and the hand's criteria, the dearest first.
struct LostItem {
  std::string name;
  double points = 0;

  bool operator==(const LostItem&) const = default;
};
std::vector<LostItem> LostItems(const ScoreResult& score);

// The target cut exactly, which is an acceptable cut. Errors: those of TargetShape. Requires: the target's prepared tooth
// is loaded.
Result<cutting::Volume> ExactCut(const scene::Scene& scene, const scene::Exercise& exercise,
                                 const cutting::Volume& initial);

// `progress` (0..1) may be empty; false ends the trial.
// Errors: those of TargetShape, ComputeMetrics, CheckCriticalIsMeasured and ApplyRubric;
// kUnavailable when ended by `progress`. Requires: the target's prepared tooth is loaded.
Result<Trial> TryExercise(const scene::Scene& scene, const scene::Exercise& exercise,
                          const cutting::Volume& initial,
                          const std::function<bool(double)>& progress = {});

}  // namespace enamel::scoring
