#include "server/app/publish.h"

#include <algorithm>
#include <optional>

#include "common/import/scene_folder.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"
#include "server/app/data_folder.h"

namespace enamel::server::app {
namespace {

constexpr std::string_view kBuiltinPrefix = "builtin:";

Result<SceneRow> StoreScene(ContentStore& store, const scene::Scene& scene, ByteView volume) {
  // Volume first, then the document that names it, then the row that names both. A crash in between
  // leaves blobs that nothing names, which retention removes; never a name without its blob.
  ENAMEL_ASSIGN_OR_RETURN(auto volume_hash, store.PutBlob(volume));
  std::string json = scene::ToJson(scene);
  ENAMEL_ASSIGN_OR_RETURN(auto content, store.PutBlob(AsBytes(json)));
  SceneRow row{scene.name, scene.title, content, volume_hash};
  ENAMEL_RETURN_IF_ERROR(store.PutScene(row, kCommandLine));
  return row;
}

Result<SceneRow> PublishBuiltin(ContentStore& store, const std::string& name, int32_t voxel_nm) {
  ENAMEL_ASSIGN_OR_RETURN(auto built, scene::BuildBuiltinScene(name, voxel_nm));
  return StoreScene(store, built.scene, scene::EncodeVolume(built.volume));
}

Result<SceneRow> PublishFolder(ContentStore& store, const std::string& folder) {
  auto found = import::LoadSceneFolder(folder);
  if (!found.ok()) {
    return Status(found.status().code(),
                  "expected a scene folder (enamel-station import makes one) or builtin:molar: " +
                      found.status().message(),
                  found.status().field());
  }
  return StoreScene(store, found->scene, found->volume_blob);
}

// As a draft that is published at once: drafts are assigned to nobody.
Result<ExerciseRow> PublishUnassigned(ContentStore& store, const ExerciseRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(auto versions, store.ExerciseVersions(row.name));
  // The newest published or retired version decides: when it says the same and is offered, there is
  // nothing to publish. A retired one is published again as a new version.
  for (const ExerciseRow& version : versions) {
    if (version.state == ExerciseState::kDraft) continue;
    if (version.content == row.content && version.state == ExerciseState::kPublished) {
      return version;
    }
    break;
  }
  auto draft = store.PutDraft(row, kCommandLine);
  if (!draft.ok()) return draft;
  return store.PublishDraft(draft->id, draft->revision, kCommandLine);
}

const Actor kProgram{{}, "built-in profiles"};

// Who put the newest version. One that a program from before said of itself as an admin would have
// is taken for an admin's.
Result<bool> IsOfTheProgram(AuditStore& audit, const std::string& profile) {
  ENAMEL_ASSIGN_OR_RETURN(
      const auto rows, audit.FindAudit({.action = "profile.put", .object = profile, .limit = 1}));
  return !rows.empty() && rows.front().actor == kProgram.via;
}

Result<scene::Scene> StoredScene(ContentStore& store, const SceneRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(auto text, store.GetBlob(row.content));
  return scene::SceneFromJson(AsText(text));
}

}  // namespace

Result<SceneRow> PublishScene(ContentStore& store, const std::string& source, int32_t voxel_nm) {
  if (!source.starts_with(kBuiltinPrefix)) return PublishFolder(store, source);
  return PublishBuiltin(store, source.substr(kBuiltinPrefix.size()), voxel_nm);
}

Result<ExerciseRow> PublishDocument(ContentStore& store, const scene::Exercise& exercise,
                                    const std::optional<Uuid>& cohort) {
  ENAMEL_ASSIGN_OR_RETURN(auto content, store.PutBlob(AsBytes(scene::ToJson(exercise))));
  ExerciseRow row;
  row.name = exercise.name;
  row.title = exercise.title;
  row.content = content;
  row.scene = exercise.scene;
  row.graded = exercise.graded;
  if (cohort) return store.PublishExercise(row, *cohort, kCommandLine);
  return PublishUnassigned(store, row);
}

Result<std::vector<ExerciseRow>> PublishBuiltins(ContentStore& store, const SceneRow& row,
                                                 const std::string& name,
                                                 const std::optional<Uuid>& cohort) {
  auto scene = StoredScene(store, row);
  if (!scene.ok()) return scene.status();
  std::vector<ExerciseRow> out;
  std::string known;
  for (const scene::Exercise& exercise : scene::BuiltinExercises(*scene, row.content)) {
    known += (known.empty() ? "" : ", ") + exercise.name;
    // Names are KIND-SCENE ("class-1-molar-46"), so that a kind with its hyphen is a prefix of just
    // its own.
    if (!name.empty() && exercise.name != name && !exercise.name.starts_with(name + "-")) continue;
    ENAMEL_ASSIGN_OR_RETURN(auto published, PublishDocument(store, exercise, cohort));
    out.push_back(published);
  }
  if (!out.empty()) return out;
  return Status(Code::kNotFound,
                "scene \"" + row.name + "\" has no exercise \"" + name + "\", it has: " + known,
                "name");
}

Result<ExerciseRow> PublishClassOne(ContentStore& store, const SceneRow& row, const Uuid& cohort) {
  auto scene = StoredScene(store, row);
  if (!scene.ok()) return scene.status();
  return PublishDocument(store, scene::ClassOneExercise(*scene, row.content), cohort);
}

Status PublishProfiles(Parts<ContentStore, AuditStore> store) {
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

}  // namespace enamel::server::app
