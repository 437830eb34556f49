#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/scoring/score.h"
#include "station/lab/grades/grades.h"
#include "station/lab/sheet/section.h"

// An attempt with each fault of the catalogue (common/scoring/remedies.h). Thread safety: functions,
// any thread. Not real-time.
namespace enamel::station::lab {

// The cut of a fault that FaultsOf does not make.
using OwnCut = CutPair (*)(const GradedExercise& graded);

struct Example {
  std::string_view fault;            // of the catalogue
  std::string_view metric;           // that finds it
  std::string_view scene, exercise;  // built in; the beginning of the exercise's name
  // The largest made fault (faults.h) of this name whose size has the sign of `sign`, or a cut of its
  // own.
  std::string_view made;
  double sign = 1;
  OwnCut own = nullptr;
  Plane plane = Plane::kMesiodistal;
  // Where the exercise's rubric does not judge the metric: a school's could, with these limits.
  std::vector<scene::RubricPoint> map = {};
};

// One for each fault of the catalogue but a heavy hand, which no tooth shows.
std::span<const Example> Examples();

// The cut and the whole score of an example. Errors: kInternal naming the example whose fault is not
// made in its exercise; those of GradedExercise::Score.
struct MadeExample {
  CutPair cut;
  scoring::ScoreResult score;
};
Result<MadeExample> Make(const Example& example, const GradedExercise& graded,
                         const std::vector<Fault>& made);

}  // namespace enamel::station::lab
