#include "server/http/handlers/checked_exercise.h"

#include <algorithm>

#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "server/http/handlers/seen_exercise.h"
#include "server/jobs/exercise_check.h"

namespace enamel::server::http {
namespace {

// Some device profile carries it on its scene; else why the last one does not.
Status MustBeMakeable(Store& store, const scene::Exercise& exercise) {
  ENAMEL_ASSIGN_OR_RETURN(std::vector<SceneRow> scenes, store.scenes.Scenes());
  // By content and not by name: an exercise fits one tooth, bit by bit.
  if (std::ranges::find(scenes, exercise.scene, &SceneRow::content) == scenes.end()) {
    return {Code::kInvalidInput,
            "expected the hash of a scene that this server has, found " + exercise.scene.Hex() +
                "; put the scene first (enamel-server admin publish-exercise)",
            "scene_sha256"};
  }
  if (!exercise.target.prepared.IsZero() &&
      std::ranges::find(scenes, exercise.target.prepared, &SceneRow::content) == scenes.end()) {
    return {Code::kInvalidInput,
            "expected the hash of a prepared tooth that this server has as a scene, found " +
                exercise.target.prepared.Hex() +
                "; put it first (enamel-server admin publish-exercise --prepared)",
            "target.prepared_scene_sha256"};
  }
  ENAMEL_ASSIGN_OR_RETURN(Bytes text, store.blobs.GetBlob(exercise.scene));
  Result<scene::Scene> scene = scene::SceneFromJson(AsText(text));
  if (!scene.ok()) return {Code::kInternal, scene.status().message()};
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ProfileRow> profiles, store.profiles.Profiles());
  Status refusal{Code::kConflict, "this server has no device profile yet; add one first"};
  for (const ProfileRow& row : profiles) {
    ENAMEL_ASSIGN_OR_RETURN(Bytes bytes, store.blobs.GetBlob(row.content));
    Result<scene::DeviceProfile> profile = scene::ProfileFromJson(AsText(bytes));
    // One of a newer server, say: the others may do.
    if (!profile.ok()) continue;
    // What the station and the ticket will do. An exercise that no device can carry is refused now,
    // and not at the chair.
    Result<core::CoreParams> params = scene::CompilePlan(*scene, exercise, *profile);
    if (params.ok()) return {};
    refusal = {params.status().code(), "on device " + row.name + ": " + params.status().message(),
               params.status().field()};
  }
  return refusal;
}

}  // namespace

Result<scene::Exercise> CheckedExercise(const Call& call, Store& store) {
  Result<scene::Exercise> exercise = scene::ExerciseFromJson(call.request.body);
  if (!exercise.ok()) {
    // A newer format is the sender's mistake, not this server's.
    const Status& why = exercise.status();
    bool newer = why.code() == Code::kVersion;
    return Status{newer ? Code::kInvalidInput : why.code(), why.message(), why.field()};
  }
  ENAMEL_RETURN_IF_ERROR(CheckExercise(store.blobs, *exercise));
  ENAMEL_RETURN_IF_ERROR(MustBeMakeable(store, *exercise));
  ENAMEL_RETURN_IF_ERROR(MayUseName(call, store.exercises, exercise->name));
  return exercise;
}

}  // namespace enamel::server::http
