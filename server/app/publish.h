#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "server/storage/recordings/stored_blobs.h"
#include "server/storage/store.h"
#include "server/storage/teaching/exercise_rows.h"
#include "server/storage/teaching/scene_rows.h"

// Scenes and exercises from the command line into the store.
namespace enamel::server::app {

// `source`: a scene folder (common/import/scene_folder.h: what `enamel-station import` writes), or
// builtin:NAME. A built-in scene of a name that is stored already is taken from there, not built
// again. `voxel_nm`: of built-in scenes. `material`: a file (schemas/material.schema.json) that says what cutting the
// scene's tissues takes. The scene's name then ends with the file's, since it is another scene. Errors also:
// kInvalidInput for a file's name that no scene's may end with.
Result<SceneRow> PublishScene(StoredBlobs& blobs, SceneRows& scenes, const std::string& source,
                              int32_t voxel_nm, const std::filesystem::path& material = {});

// A new version when it differs from the newest; assigned to `cohort` unless it is (zero: to
// everybody; none: to nobody).
Result<ExerciseRow> PublishDocument(StoredBlobs& blobs, ExerciseRows& exercises,
                                    const scene::Exercise& exercise,
                                    const std::optional<Uuid>& cohort);

// The exercises the project makes for a stored scene (common/scene/builtin/builtin.h): all, or
// those of this name or kind ("class-2"). Each graded one also comes as practice, named
// "practice-…". `begin` hears the name of each before it is published. Errors also: kNotFound with
// the names there are.
Result<std::vector<ExerciseRow>> PublishBuiltins(
    StoredBlobs& blobs, ExerciseRows& exercises, const SceneRow& scene, const std::string& name,
    const std::optional<Uuid>& cohort, const std::function<void(const std::string&)>& begin);
// Class I alone.
Result<ExerciseRow> PublishClassOne(StoredBlobs& blobs, ExerciseRows& exercises,
                                    const SceneRow& scene, const Uuid& cohort);

// Publishes the program's profiles: each missing one, and a newer form of each whose newest version
// came from an earlier program. A version that the school has added since stays the newest.
Status PublishProfiles(Store& store);

}  // namespace enamel::server::app
