#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/fidelity/cut_strokes.h"
#include "common/math/vec.h"

// The strokes in which simulated people remove tissue in the built-in exercises. They hold the built-in
// "pointer": its plant is stiff and light, so that the strokes are the people's and no device's. SI units.
namespace enamel::station::lab {

struct ExerciseStroke : fidelity::CutStroke {
  std::string exercise, name;  // "class-1", "dentist-2"
};

struct StrokesOptions {
  std::vector<std::string> scenes;  // of BuiltinSceneNames; none: all
  std::vector<std::string> people;  // of OperatorPresets
  int each = 2;                     // strokes of one person in one exercise
  int threads = 2;
};

// As CutStrokes finds and spreads them; the number of threads changes nothing.
// Errors: as the scenes' builder and RunOperator return them.
Result<std::vector<ExerciseStroke>> StrokesOfExercises(const StrokesOptions& options);

}  // namespace enamel::station::lab
