#pragma once

#include <string>
#include <string_view>

#include "common/scene/builtin/teeth.h"
#include "common/scene/types.h"

// The built-in exercises that have a source of their own, and what all of them use. Private to this
// folder: builtin.h has the list.
namespace enamel::scene {

// A length as a student reads it: "1.5 mm".
std::string Mm(int32_t um);
bool Has(const Scene& scene, cutting::Tissue tissue);
std::string NameFor(const char* kind, const Scene& scene);
// The built-in tooth of a scene; null for another one.
const ToothShape* ShapeOf(const Scene& scene);

// A bur that the built-in scenes offer (builtin.cpp), by its name and with its ISO number.
BurSpec OfferedBur(std::string_view name, std::string_view iso_number);

// exercises.cpp, beside ClassOneExercise: an upright hollow of each kind, with its burs and rubric.
Exercise ClassTwoExercise(const Scene& scene, const Sha256& scene_hash);
Exercise ClassFiveExercise(const Scene& scene, const Sha256& scene_hash);
// Its outline and words are drawn (drawn.h).
Exercise AccessExercise(const Scene& scene, const Sha256& scene_hash);
// crown_exercise.cpp.
Exercise CrownExercise(const Scene& scene, const Sha256& scene_hash);
// veneer_exercise.cpp. `tooth` is the scene's, turned so that its labial face is up.
Exercise VeneerExercise(const Scene& scene, const ToothShape& tooth, const Sha256& scene_hash);

}  // namespace enamel::scene
