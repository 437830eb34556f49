#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"

// Documents as canonical JSON: members in a fixed order, two-space indent, arrays of scalars on one
// line, shortest numbers, '\n' at the end, so that equal documents have equal bytes and a content
// address (SHA-256 of the text) can name them. Schemas: schemas/*.schema.json.
// Reading is strict: unknown, repeated and missing members are refused.
// Errors: kInvalidInput with the member's path in field(), kVersion for a newer format number.
// Bounded: text up to 1 MiB, depth 16. Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::scene {

std::string ToJson(const Scene& scene);
std::string ToJson(const DeviceProfile& profile);
std::string ToJson(const Exercise& exercise);
// A rubric by itself, as it corrects the one of an exercise that is published.
std::string ToJson(const Rubric& rubric);

Result<Scene> SceneFromJson(std::string_view json);
Result<DeviceProfile> ProfileFromJson(std::string_view json);
// The document's members whose source begins with "asked for": no source gives them, and each holds a
// stand-in until somebody measures or asks.
std::vector<std::string> AskedFor(const DeviceProfile& profile);
Result<Exercise> ExerciseFromJson(std::string_view json);
Result<Rubric> RubricFromJson(std::string_view json);

}  // namespace enamel::scene
