#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/math/vec.h"

// The strokes in which simulated people remove tissue in the built-in exercises. They hold the built-in
// "pointer": its plant is stiff and light, so that the strokes are the people's and no device's. SI units.
namespace enamel::station::lab {

struct ExerciseStroke {
  std::string exercise, name;  // "class-1", "dentist-2"
  std::vector<dvec3> way_m;    // of the tip, one position a millisecond
  // B that the bur met along its way: work of the resisting force over the square of the way, times the time.
  double b_n_s_per_m = 0;
  double speed_m_per_s = 0;  // of the bur, mean
  double seconds = 0;        // of the exercise's removal that this stroke stands for
};

struct StrokesOptions {
  std::vector<std::string> scenes;  // of BuiltinSceneNames; none: all
  std::vector<std::string> people;  // of OperatorPresets
  int each = 2;                     // strokes of one person in one exercise
  int threads = 2;
};

// A stroke lasts while tissue is removed, with rests of at most a tenth of a second, for 0.3 to 4 s. One person's
// strokes in one exercise are taken at even shares of the time in which tissue is removed, so that each stands
// for the same time. Deterministic: the number of threads changes nothing.
// Errors: as the scenes' builder and RunOperator return them.
Result<std::vector<ExerciseStroke>> StrokesOfExercises(const StrokesOptions& options);

}  // namespace enamel::station::lab
