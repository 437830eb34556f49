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

// The two attempts that show whether a rubric is right: it has to give full marks for the target
// cut exactly, and none for a tooth that nobody touched. Of the hand's figures those count that a
// calm recording has: nobody moved a bur for these.
struct Trial {
  // A criterion with the share of its points before the gates, or a gate with the share of all
  // points that it leaves.
  struct Item {
    std::string metric, title;
    double share = 1;

    bool operator==(const Item&) const = default;
  };
  ScoreResult exact, untouched;
  std::vector<Item> lost_by_exact;   // those of CostlyCriteria
  std::vector<Item> full_untouched;  // criteria with full points, after the gates
};

// `progress` (0..1) may be empty; false ends the trial.
// Errors: those of TargetShape, ComputeMetrics, CheckCriticalIsMeasured and ApplyRubric;
// kUnavailable when ended by `progress`. Requires: the target's prepared tooth is loaded.
Result<Trial> TryExercise(const scene::Scene& scene, const scene::Exercise& exercise,
                          const cutting::Volume& initial,
                          const std::function<bool(double)>& progress = {});

}  // namespace enamel::scoring
