#include "server/app/publish.h"

#include <algorithm>
#include <optional>

#include "common/base/file.h"
#include "common/import/scene_folder.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/material.h"
#include "common/scene/volume_blob.h"
#include "server/app/data_folder.h"
#include "server/jobs/builtin_content.h"
#include "server/jobs/exercise_check.h"

namespace enamel::server::app {
namespace {

constexpr std::string_view kBuiltinPrefix = "builtin:";

Result<SceneRow> PublishFolder(StoredBlobs& blobs, SceneRows& scenes, const std::string& folder) {
  auto found = import::LoadSceneFolder(folder);
  if (!found.ok()) {
    return Status(found.status().code(),
                  "expected a scene folder (enamel-station import makes one) or builtin:molar: " +
                      found.status().message(),
                  found.status().field());
  }
  return StoreScene(blobs, scenes, found->scene, found->volume_blob, kCommandLine);
}

constexpr size_t kMaxMaterialBytes = size_t{1} << 20;
constexpr size_t kLongestEnding = 24;  // of the 64 that a scene's name may have

Result<SceneRow> PublishWithMaterial(StoredBlobs& blobs, SceneRows& scenes,
                                     const std::string& source, int32_t voxel_nm,
                                     const std::filesystem::path& material) {
  const std::string ending = material.stem().string();
  const bool plain = std::ranges::all_of(ending, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
  if (!plain || ending.empty() || ending.size() > kLongestEnding) {
    return Status(
        Code::kInvalidInput,
        "the scene is named after the material: expected a file's name of 1 to 24 lower-case "
        "letters, digits, - and _, as soft-enamel.json; found " +
            material.filename().string(),
        "material");
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto text, ReadFile(material, kMaxMaterialBytes));
  ENAMEL_ASSIGN_OR_RETURN(const auto law, scene::MaterialFromJson(AsText(text)));
  ENAMEL_ASSIGN_OR_RETURN(auto built, import::LoadScene(source, voxel_nm));
  ENAMEL_RETURN_IF_ERROR(scene::ApplyMaterial(law, &built.scene));
  built.scene.name += "-" + ending;
  return StoreScene(blobs, scenes, built.scene, scene::EncodeVolume(built.volume), kCommandLine);
}

Result<scene::Scene> StoredScene(StoredBlobs& blobs, const SceneRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(auto text, blobs.GetBlob(row.content));
  return scene::SceneFromJson(AsText(text));
}

// The same task to practise: target, progress and score are seen at once.
scene::Exercise AsPractice(scene::Exercise exercise) {
  constexpr size_t kLongestName = 64;  // json/read.h
  exercise.name = ("practice-" + exercise.name).substr(0, kLongestName);
  exercise.graded = false;
  return exercise;
}

}  // namespace

Result<SceneRow> PublishScene(StoredBlobs& blobs, SceneRows& scenes, const std::string& source,
                              int32_t voxel_nm, const std::filesystem::path& material) {
  if (!material.empty()) return PublishWithMaterial(blobs, scenes, source, voxel_nm, material);
  if (!source.starts_with(kBuiltinPrefix)) return PublishFolder(blobs, scenes, source);
  return StoreBuiltinScene(blobs, scenes, source.substr(kBuiltinPrefix.size()), voxel_nm,
                           kCommandLine);
}

Result<ExerciseRow> PublishDocument(StoredBlobs& blobs, ExerciseRows& exercises,
                                    const scene::Exercise& exercise,
                                    const std::optional<Uuid>& cohort) {
  ENAMEL_RETURN_IF_ERROR(CheckExercise(blobs, exercise));
  if (!cohort) return PublishUnassigned(blobs, exercises, exercise, kCommandLine);
  ENAMEL_ASSIGN_OR_RETURN(const auto row, StoreExercise(blobs, exercise));
  return exercises.PublishExercise(row, *cohort, kCommandLine);
}

Result<std::vector<ExerciseRow>> PublishBuiltins(
    StoredBlobs& blobs, ExerciseRows& exercises, const SceneRow& row, const std::string& name,
    const std::optional<Uuid>& cohort, const std::function<void(const std::string&)>& begin) {
  auto scene = StoredScene(blobs, row);
  ENAMEL_RETURN_IF_ERROR(scene.status());
  std::vector<ExerciseRow> out;
  std::string known;
  for (const scene::Exercise& exercise : scene::BuiltinExercises(*scene, row.content)) {
    known += (known.empty() ? "" : ", ") + exercise.name;
    // Names are KIND-SCENE ("class-1-molar-46"), so that a kind with its hyphen is a prefix of just
    // its own.
    if (!name.empty() && exercise.name != name && !exercise.name.starts_with(name + "-")) continue;
    std::vector<scene::Exercise> forms{exercise};
    if (exercise.graded) forms.push_back(AsPractice(exercise));
    for (const scene::Exercise& form : forms) {
      begin(form.name);
      ENAMEL_ASSIGN_OR_RETURN(auto published, PublishDocument(blobs, exercises, form, cohort));
      out.push_back(published);
    }
  }
  if (!out.empty()) return out;
  return Status(Code::kNotFound,
                "scene \"" + row.name + "\" has no exercise \"" + name + "\", it has: " + known,
                "name");
}

Result<ExerciseRow> PublishClassOne(StoredBlobs& blobs, ExerciseRows& exercises,
                                    const SceneRow& row, const Uuid& cohort) {
  auto scene = StoredScene(blobs, row);
  ENAMEL_RETURN_IF_ERROR(scene.status());
  return PublishDocument(blobs, exercises, scene::ClassOneExercise(*scene, row.content), cohort);
}

Status PublishProfiles(Store& store) { return PutBuiltinProfiles(store); }

}  // namespace enamel::server::app
