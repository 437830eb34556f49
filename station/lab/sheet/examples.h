#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/scoring/score.h"
#include "station/lab/grades/grades.h"
#include "station/lab/sheet/section.h"

// An attempt with each mistake that a score can name. Thread safety: functions, any thread. Not
// real-time.
namespace enamel::station::lab {

// The cut of a mistake that FaultsOf does not make.
using OwnCut = CutPair (*)(const GradedExercise& graded);

struct Example {
  scoring::MistakeKind kind = scoring::MistakeKind::kUneven;
  std::string_view scene, exercise;  // built in; the beginning of the exercise's name
  // The smallest made fault (faults.h) of this name that must cost a point and whose size has the sign
  // of `sign`, or a cut of its own.
  std::string_view made;
  double sign = 1;
  OwnCut own = nullptr;
  Plane plane = Plane::kMesiodistal;
};

// One for each kind but kUneven, which is what no kind explains.
std::span<const Example> Examples();

// The cut of an example, and the dearest of its kind that the score names there. Errors: kInternal naming the example
// whose fault is not made in its exercise, or is not named; those of GradedExercise::Score.
struct MadeExample {
  CutPair cut;
  scoring::Mistake mistake;
};
Result<MadeExample> Make(const Example& example, const GradedExercise& graded,
                         const std::vector<Fault>& made);

}  // namespace enamel::station::lab
