#pragma once

#include <cstdint>
#include <string_view>

namespace enamel::scene {

// The first member of a document says what it is and which format of it: {"enamel_scene": 1, …}.
inline constexpr int64_t kFormat = 1;
inline constexpr std::string_view kSceneKind = "enamel_scene", kExerciseKind = "enamel_exercise",
                                  kProfileKind = "enamel_device_profile",
                                  kRubricKind = "enamel_rubric",
                                  kCalibrationKind = "enamel_calibration",
                                  kMaterialKind = "enamel_material",
                                  kBuiltinExerciseKind = "enamel_builtin_exercise";

}  // namespace enamel::scene
