#include "common/scene/attempt_documents.h"

#include "common/scene/delay.h"
#include "common/scene/json/json.h"

namespace enamel::scene {
namespace {

Status Another(const char* what, const char* field, const char* by, const Sha256& expected,
               const Sha256& found) {
  return Status(Code::kConflict,
                std::string("the recording names another ") + what + " than " + by +
                    " does: expected " + expected.Hex() + ", found " + found.Hex(),
                field);
}

}  // namespace

Result<AttemptDocuments> ReadDocuments(const Sha256& exercise, const Sha256& profile,
                                       const FetchContent& fetch) {
  ENAMEL_ASSIGN_OR_RETURN(auto exercise_text, fetch(exercise));
  ENAMEL_ASSIGN_OR_RETURN(auto read_exercise, ExerciseFromJson(AsText(exercise_text)));
  ENAMEL_ASSIGN_OR_RETURN(auto profile_text, fetch(profile));
  ENAMEL_ASSIGN_OR_RETURN(auto read_profile, ProfileFromJson(AsText(profile_text)));
  // The scene by the exercise's word, not the recording's: CheckMadeOf compares the two.
  ENAMEL_ASSIGN_OR_RETURN(auto scene_text, fetch(read_exercise.scene));
  ENAMEL_ASSIGN_OR_RETURN(auto read_scene, SceneFromJson(AsText(scene_text)));
  return AttemptDocuments{std::move(read_exercise), std::move(read_profile), std::move(read_scene)};
}

Status CheckMadeOf(const AttemptDocuments& documents, const Sha256& scene, const Sha256& volume,
                   const core::CoreParams& params) {
  // By name first: two hashes say more than "other parameters", which would follow from either.
  if (scene != documents.exercise.scene) {
    return Another("scene", "scene", "its exercise", documents.exercise.scene, scene);
  }
  if (volume != documents.scene.volume) {
    return Another("volume", "volume", "its scene", documents.scene.volume, volume);
  }
  Status status = CheckParams(documents.scene, documents.exercise, documents.profile, params);
  if (status.code() != Code::kConflict || status.field() != "params") return status;
  return Status(Code::kConflict,
                "the recording was made with other core parameters than exercise \"" +
                    documents.exercise.name + "\" and device profile \"" + documents.profile.name +
                    "\" give",
                "params");
}

}  // namespace enamel::scene
