#pragma once

#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"

// Built-in exercises whose outline somebody drew: documents of schemas/builtin_exercise.schema.json,
// compiled in from schemas/exercises. A document gives the words and the outline in the tooth's own
// frame: x to mesial, y to buccal, on either side of the jaw. It names an exercise whose burs, rubric
// and time the new one shares. Private to this folder: builtin.h lists all exercises. Thread safety:
// functions, any thread.
namespace enamel::scene {

// The documents' texts. Written by CMake.
std::vector<std::string_view> DrawnDocuments();

struct DrawnExercise {
  std::string name, like, title, instructions;
  std::vector<std::string> scenes;  // by their names, without kByLoadSuffix
  std::string landmark;
  std::vector<PreparationPart> parts;  // from the landmark, x to mesial
};
// Errors: kInvalidInput with the member's path.
Result<DrawnExercise> DrawnFromJson(std::string_view text);

// The exercises that are drawn for a scene, in the order of the documents' names.
std::vector<Exercise> DrawnExercises(const Scene& scene, const Sha256& scene_hash);

}  // namespace enamel::scene
