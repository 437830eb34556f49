#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "server/storage/recordings/stored_blobs.h"
#include "server/storage/store.h"
#include "server/storage/teaching/scene_rows.h"

// Exercises whose target is a prepared tooth (common/scene/prepared_target.h): from a scan, or from
// a reference's cut. As the commands of admin.h.
namespace enamel::server::app {

// The folder that `enamel-station target` wrote: the prepared tooth becomes a scene beside `scene`,
// which is stored already, and exercise.json is published. Errors: kConflict where the folder was
// made for another tooth; kNotFound; whatever is wrong in a document.
Result<ExerciseRow> PublishPrepared(Store& store, const SceneRow& scene,
                                    const std::filesystem::path& folder,
                                    const std::optional<Uuid>& cohort);

// Reads the prepared tooth that an exercise's target names, where it names one, and checks that it
// is one of the exercise's tooth. Errors: as LoadPreparedTarget; kNotFound where it is no scene
// here.
Status CheckPrepared(StoredBlobs& blobs, SceneRows& scenes_rows, const scene::Exercise& exercise);

// Makes the tooth that the newest reference of the newest published version left the target of the
// next version. `tolerance_um`: leeway; none: unchanged.
struct FromReference {
  std::string exercise;  // name
  std::optional<int32_t> tolerance_um;
  std::string anyway;  // why, although the reference is refused without (jobs/reference_check.h)
};
Status TargetFromReference(const std::filesystem::path& data, const FromReference& wanted);

struct CommandGroup;
void DeclareTargets(CommandGroup admin);

}  // namespace enamel::server::app
