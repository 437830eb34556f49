#pragma once

#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "server/storage/audit/actor.h"
#include "server/storage/recordings/stored_blobs.h"
#include "server/storage/store.h"
#include "server/storage/teaching/exercise_rows.h"
#include "server/storage/teaching/scene_rows.h"

// Teeth, exercises and device profiles into the store, for whoever asks for them: the command line,
// and the page of a new server. Thread safety: functions, any thread; they block.
namespace enamel::server {

// Volume, document, and the row that names both.
Result<SceneRow> StoreScene(StoredBlobs& blobs, SceneRows& scenes, const scene::Scene& scene,
                            ByteView volume, const Actor& by);

// One that the project makes itself (common/scene/builtin). Takes seconds for a fine tooth. Errors:
// those of scene::BuildBuiltinScene and of the store.
Result<SceneRow> StoreBuiltinScene(StoredBlobs& blobs, SceneRows& scenes, std::string_view name,
                                   int32_t voxel_nm, const Actor& by);

// The document into the store, and the row that names it: without a version, published by nobody
// yet.
Result<ExerciseRow> StoreExercise(StoredBlobs& blobs, const scene::Exercise& exercise);

// The next version of its name, assigned to nobody; the newest one where that says the same and is
// offered.
Result<ExerciseRow> PublishUnassigned(StoredBlobs& blobs, ExerciseRows& exercises,
                                      const scene::Exercise& exercise, const Actor& by);

// The exercises that the project makes for a stored tooth (scene::BuiltinExercises), each as
// PublishUnassigned. `practice`: none is graded.
Result<std::vector<ExerciseRow>> PublishExercisesOf(StoredBlobs& blobs,
                                                    ExerciseRows& exercises_rows,
                                                    const scene::Scene& scene,
                                                    const Sha256& content, const Actor& by,
                                                    bool practice = false);

// The program's profiles. A profile that an admin has put stays.
Status PutBuiltinProfiles(Store& store);
// The same where there are none yet: without one no exercise can be begun.
Status PutFirstProfiles(Store& store);

}  // namespace enamel::server
