#include "server/jobs/builtin_content.h"

#include <algorithm>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"

namespace enamel::server {
namespace {

const Actor kProgram{{}, "built-in profiles"};

// Whether the program put the newest version.
Result<bool> IsOfTheProgram(AuditRows& audit, const std::string& profile) {
  ENAMEL_ASSIGN_OR_RETURN(
      const auto rows, audit.FindAudit({.action = "profile.put", .object = profile, .limit = 1}));
  return !rows.empty() && rows.front().actor == kProgram.via;
}

}  // namespace

Result<SceneRow> StoreScene(StoredBlobs& blobs, SceneRows& scenes, const scene::Scene& scene,
                            ByteView volume, const Actor& by) {
  // Volume first, then the document that names it, then the row that names both. A crash in between
  // leaves blobs that nothing names, which retention removes; never a name without its blob.
  ENAMEL_ASSIGN_OR_RETURN(auto volume_hash, blobs.PutBlob(volume));
  ENAMEL_ASSIGN_OR_RETURN(auto content, blobs.PutBlob(AsBytes(scene::ToJson(scene))));
  SceneRow row{scene.name, scene.title, content, volume_hash};
  ENAMEL_RETURN_IF_ERROR(scenes.PutScene(row, by));
  return row;
}

Result<SceneRow> StoreBuiltinScene(StoredBlobs& blobs, SceneRows& scenes, std::string_view name,
                                   int32_t voxel_nm, const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(auto built, scene::BuildBuiltinScene(name, voxel_nm));
  return StoreScene(blobs, scenes, built.scene, scene::EncodeVolume(built.volume), by);
}

Result<ExerciseRow> StoreExercise(StoredBlobs& blobs, const scene::Exercise& exercise) {
  ENAMEL_ASSIGN_OR_RETURN(auto content, blobs.PutBlob(AsBytes(scene::ToJson(exercise))));
  ExerciseRow row;
  row.name = exercise.name;
  row.title = exercise.title;
  row.content = content;
  row.scene = exercise.scene;
  row.graded = exercise.graded;
  return row;
}

Result<ExerciseRow> PublishUnassigned(StoredBlobs& blobs, ExerciseRows& exercises,
                                      const scene::Exercise& exercise, const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(auto row, StoreExercise(blobs, exercise));
  ENAMEL_ASSIGN_OR_RETURN(const auto versions, exercises.ExerciseVersions(row.name));
  // The newest published or retired version decides: when it says the same and is offered, there is
  // nothing to publish. A retired one is published again as a new version.
  for (const ExerciseRow& version : versions) {
    if (version.state == ExerciseState::kDraft) continue;
    if (version.content == row.content && version.state == ExerciseState::kPublished) {
      return version;
    }
    break;
  }
  // As a draft that is published at once: drafts are assigned to nobody.
  auto draft = exercises.PutDraft(row, by);
  ENAMEL_RETURN_IF_ERROR(draft.status());
  return exercises.PublishDraft(draft->id, draft->revision, by);
}

Result<std::vector<ExerciseRow>> PublishExercisesOf(StoredBlobs& blobs,
                                                    ExerciseRows& exercises_rows,
                                                    const scene::Scene& scene,
                                                    const Sha256& content, const Actor& by,
                                                    bool practice) {
  std::vector<ExerciseRow> out;
  for (scene::Exercise& exercise : scene::BuiltinExercises(scene, content)) {
    if (practice) exercise.graded = false;
    ENAMEL_ASSIGN_OR_RETURN(const auto published,
                            PublishUnassigned(blobs, exercises_rows, exercise, by));
    out.push_back(published);
  }
  return out;
}

Status PutFirstProfiles(Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(const auto profiles, store.profiles.Profiles());
  return profiles.empty() ? PutBuiltinProfiles(store) : Status::Ok();
}

Status PutBuiltinProfiles(Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(const auto stored, store.profiles.Profiles());
  for (const scene::DeviceProfile& profile : scene::BuiltinProfiles()) {
    if (std::ranges::find(stored, profile.name, &ProfileRow::name) != stored.end()) {
      ENAMEL_ASSIGN_OR_RETURN(const bool ours, IsOfTheProgram(store.audit, profile.name));
      if (!ours) continue;
    }
    ENAMEL_ASSIGN_OR_RETURN(auto content, store.blobs.PutBlob(AsBytes(scene::ToJson(profile))));
    ENAMEL_RETURN_IF_ERROR(
        store.profiles.PutProfile({profile.name, profile.title, content}, kProgram));
  }
  return Status::Ok();
}

}  // namespace enamel::server
