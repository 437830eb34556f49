#pragma once

#include <boost/json/fwd.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/scoring/trial.h"
#include "station/lab/grades/faults.h"
#include "station/lab/grades/judged.h"

// The cost of a known fault: attempts made by formula (faults.h), measured and graded by the
// exercise's own rubric against the task itself. Document: schemas/lab_grades.schema.json. Thread
// safety: functions, any thread. Blocks.
namespace enamel::station::lab {

struct GradesOptions {
  std::vector<int32_t> voxels_nm = {100'000, 50'000, 25'000};
  bool quick = false;                  // the coarsest voxel size, one size of each fault
  std::vector<std::string> exercises;  // names or their beginnings; empty: all built in
};

struct GradeRow {
  std::string exercise, fault;
  double size = 0;
  std::string unit;
  double voxel_mm = 0;
  std::string metric;
  std::optional<double> found;  // empty: the attempt has nothing to measure
  double tolerance = 0;         // limit of |found - size|
  double points_lost = 0, score = 0;
  std::string critical_expected, critical;  // the error that was made and the first found, or none
  bool borderline = false;                  // it is: a person decides
  bool must_cost = true;                    // at or over its threshold: must cost at least a point
  std::optional<double> may_cost;           // points, at most
  Judged judged;

  // Cost enough for its first mistake to be asked for.
  bool NamesItsMistake() const;
  bool IsCrown() const;  // or a veneer: its reduction has no walls
  bool AsKnown() const;
  bool CostsEnough() const;
  bool CostsTooMuch() const;
};

// One tooth and exercise with its task, ready to grade attempts at it.
class GradedExercise {
 public:
  // Errors: those of TaskOf.
  static Result<GradedExercise> Make(const scene::BuiltScene& built, scene::Exercise exercise);

  // The score after removing `taken`, against the task itself, as if by a calm hand within the
  // time. Errors: those of scoring::ComputeMetrics.
  Result<scoring::ScoreResult> Score(const Hollow& taken, Neighbours neighbours) const;
  Result<GradeRow> Grade(const Fault& fault) const;

  // The task, as an acceptable cut.
  const scoring::AcceptableCut& r() const { return *r_; }
  const scene::BuiltScene& built() const { return *built_; }
  const scene::Exercise& exercise() const { return exercise_; }
  const Task& task() const { return task_; }

 private:
  GradedExercise(const scene::BuiltScene& built, scene::Exercise exercise, Task task);
  Result<scoring::ScoreResult> ScoreOf(const cutting::Volume& attempt) const;

  const scene::BuiltScene* built_;
  scene::Exercise exercise_;
  Task task_;
  std::unique_ptr<scoring::CalmAttempts> attempts_;
  std::unique_ptr<scoring::AcceptableCut> r_;  // of their exact cut
};

// Works scene by scene. `row` is called with each row as it comes, `progress` (what, 0..1) between
// them; both may be empty. Errors: kNotFound when no exercise has such a name; those of the scene's
// builder.
Result<std::vector<GradeRow>> MeasureGrades(
    const GradesOptions& options, const std::function<void(const GradeRow&)>& row = {},
    const std::function<void(const std::string&, double)>& progress = {});

// Pairs of rows, of one fault at two sizes, in which the larger one costs less, by more than voxels make.
std::vector<std::string> CheaperThoughLarger(const std::vector<GradeRow>& rows);

boost::json::object GradesJson(const std::vector<GradeRow>& rows);

}  // namespace enamel::station::lab
