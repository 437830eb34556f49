#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "server/storage/recordings/stored_blobs.h"

// Whether an exercise can be done and judged on its tooth: asked when it is edited and when it is
// published, by page, API and command alike. Thread safety: functions, any thread; they block for
// the store.
namespace enamel::server {

// Less time than this is no exercise: a hand needs as long to take the tool up. Chosen.
inline constexpr int32_t kMinTime_s = 30;

// Errors: kInvalidInput with the member, what was expected and found: the rubric (ValidateRubric,
// CheckRubricWords; a price for each kind of region that a target like this has), a landmark that the scene does not have, a time limit of seconds, a bur that
// is wider than the target, graded work whose voxels are too coarse for its bur
// (common/cutting/voxel_limit.h), a target wider than the tooth or through a pulp whose opening
// fails the attempt, a critical error of caries, a neighbour or a crown where there is none. What needs
// scene or volume is left out where that cannot be read.
Status CheckExercise(StoredBlobs& blobs, const scene::Exercise& exercise);

// What is allowed, for people: "the text says 3 mm deep, the target is 2 mm deep", practice whose
// voxels are too coarse for its bur.
std::vector<std::string> ExerciseWarnings(StoredBlobs& blobs, const scene::Exercise& exercise);

}  // namespace enamel::server
