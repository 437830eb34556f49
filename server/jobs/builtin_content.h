#pragma once

#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "server/storage/parts.h"

// Teeth, exercises and device profiles into the store, for whoever asks for them: the command line, and
// the page of a new server. Thread safety: functions, any thread; they block.
namespace enamel::server {

// Volume, document, and the row that names both.
Result<SceneRow> StoreScene(ContentStore& store, const scene::Scene& scene, ByteView volume,
                            const Actor& by);

// One that the project makes itself (common/scene/builtin). Takes seconds for a fine tooth. Errors: those
// of scene::BuildBuiltinScene and of the store.
Result<SceneRow> StoreBuiltinScene(ContentStore& store, std::string_view name, int32_t voxel_nm,
                                   const Actor& by);

// The document into the store, and the row that names it: without a version, published by nobody yet.
Result<ExerciseRow> StoreExercise(ContentStore& store, const scene::Exercise& exercise);

// The next version of its name, assigned to nobody; the newest one where that says the same and is
// offered.
Result<ExerciseRow> PublishUnassigned(ContentStore& store, const scene::Exercise& exercise,
                                      const Actor& by);

// The exercises that the project makes for a stored tooth (scene::BuiltinExercises), each as
// PublishUnassigned.
Result<std::vector<ExerciseRow>> PublishExercisesOf(ContentStore& store, const scene::Scene& scene,
                                                    const Sha256& content, const Actor& by);

// The profiles of the program. One that an admin put, or put anew, stays.
Status PutBuiltinProfiles(Parts<ContentStore, AuditStore> store);
// The same where there are none yet: without one no exercise can be begun.
Status PutFirstProfiles(Parts<ContentStore, AuditStore> store);

}  // namespace enamel::server
