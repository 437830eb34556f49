#pragma once

#include <string>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "server/storage/store.h"

// Scenes and exercises from the command line into the store.
namespace enamel::server::app {

// `source`: a folder with scene.json and the volume blob that it names by its hash (what
// `enamel-station import` writes), or builtin:NAME. A built-in scene of a name that is stored
// already is taken from there, not built again. `voxel_nm`: of built-in scenes.
Result<SceneRow> PublishScene(Store& store, const std::string& source, int32_t voxel_nm);

// The class I exercise on a stored scene; a new version when it differs from the newest.
Result<ExerciseRow> PublishClassOne(Store& store, const SceneRow& scene, const Uuid& cohort);

// The three profiles of the program.
Status PublishProfiles(Store& store);

}  // namespace enamel::server::app
