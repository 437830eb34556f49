#include "server/jobs/builtin_content.h"

#include <algorithm>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"

namespace enamel::server {
namespace {

const Actor kProgram{{}, "built-in profiles"};

// Whether the program put the newest version.
Result<bool> IsOfTheProgram(AuditStore& audit, const std::string& profile) {
  ENAMEL_ASSIGN_OR_RETURN(
      const auto rows, audit.FindAudit({.action = "profile.put", .object = profile, .limit = 1}));
  return !rows.empty() && rows.front().actor == kProgram.via;
}

}  // namespace

Result<SceneRow> StoreScene(ContentStore& store, const scene::Scene& scene, ByteView volume,
                            const Actor& by) {
  // Volume first, then the document that names it, then the row that names both. A crash in between
  // leaves blobs that nothing names, which retention removes; never a name without its blob.
  ENAMEL_ASSIGN_OR_RETURN(auto volume_hash, store.PutBlob(volume));
  ENAMEL_ASSIGN_OR_RETURN(auto content, store.PutBlob(AsBytes(scene::ToJson(scene))));
  SceneRow row{scene.name, scene.title, content, volume_hash};
  ENAMEL_RETURN_IF_ERROR(store.PutScene(row, by));
  return row;
}

Result<SceneRow> StoreBuiltinScene(ContentStore& store, std::string_view name, int32_t voxel_nm,
                                   const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(auto built, scene::BuildBuiltinScene(name, voxel_nm));
  return StoreScene(store, built.scene, scene::EncodeVolume(built.volume), by);
}

Result<ExerciseRow> StoreExercise(ContentStore& store, const scene::Exercise& exercise) {
  ENAMEL_ASSIGN_OR_RETURN(auto content, store.PutBlob(AsBytes(scene::ToJson(exercise))));
  ExerciseRow row;
  row.name = exercise.name;
  row.title = exercise.title;
  row.content = content;
  row.scene = exercise.scene;
  row.graded = exercise.graded;
  return row;
}

Result<ExerciseRow> PublishUnassigned(ContentStore& store, const scene::Exercise& exercise,
                                      const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(auto row, StoreExercise(store, exercise));
  ENAMEL_ASSIGN_OR_RETURN(const auto versions, store.ExerciseVersions(row.name));
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
  auto draft = store.PutDraft(row, by);
  if (!draft.ok()) return draft;
  return store.PublishDraft(draft->id, draft->revision, by);
}

Result<std::vector<ExerciseRow>> PublishExercisesOf(ContentStore& store, const scene::Scene& scene,
                                                    const Sha256& content, const Actor& by) {
  std::vector<ExerciseRow> out;
  const std::vector<scene::Exercise> exercises = scene::BuiltinExercises(scene, content);
  for (const scene::Exercise& exercise : exercises) {
    ENAMEL_ASSIGN_OR_RETURN(const auto published, PublishUnassigned(store, exercise, by));
    out.push_back(published);
  }
  return out;
}

Status PutFirstProfiles(Parts<ContentStore, AuditStore> store) {
  ENAMEL_ASSIGN_OR_RETURN(const auto profiles, store.content().Profiles());
  return profiles.empty() ? PutBuiltinProfiles(store) : Status::Ok();
}

Status PutBuiltinProfiles(Parts<ContentStore, AuditStore> store) {
  ENAMEL_ASSIGN_OR_RETURN(const auto stored, store.content().Profiles());
  for (const scene::DeviceProfile& profile : scene::BuiltinProfiles()) {
    if (std::ranges::find(stored, profile.name, &ProfileRow::name) != stored.end()) {
      ENAMEL_ASSIGN_OR_RETURN(const bool ours, IsOfTheProgram(store.audit(), profile.name));
      if (!ours) continue;
    }
    ENAMEL_ASSIGN_OR_RETURN(auto content, store.content().PutBlob(AsBytes(scene::ToJson(profile))));
    ENAMEL_RETURN_IF_ERROR(
        store.content().PutProfile({profile.name, profile.title, content}, kProgram));
  }
  return Status::Ok();
}

}  // namespace enamel::server
