#include "server/commands/prepared.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/json.hpp>

#include "common/base/file.h"
#include "common/scene/json/json.h"
#include "common/scene/prepared_target.h"
#include "common/scene/volume_blob.h"
#include "server/app/data_folder.h"
#include "server/app/publish.h"
#include "server/commands/command_line.h"
#include "server/commands/console_phases.h"
#include "server/commands/say.h"
#include "server/jobs/reference_check.h"
#include "server/jobs/stored_tooth.h"
#include "server/training/names.h"

namespace enamel::server::app {
namespace {

Result<ExerciseRow> NewestVersion(ExerciseRows& exercises_rows, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(const auto versions, exercises_rows.ExerciseVersions(name));
  for (const ExerciseRow& row : versions) {
    if (row.state == ExerciseState::kPublished) return row;
  }
  return Status(Code::kNotFound, "no published exercise \"" + name +
                                     "\"; enamel-server admin list-exercises shows their names");
}

// The scene of the tooth that a reference left. It does not name the reference's author: documents
// go to every station.
scene::Scene PreparedScene(const scene::Scene& from, const ExerciseRow& exercise,
                           const Sha256& volume) {
  scene::Scene out = from;
  out.name = from.name.substr(0, 55) + "-prepared";
  out.title = from.title.substr(0, 180) + ", prepared";
  out.preparations.clear();
  out.volume = volume;
  out.provenance = "the tooth that a reference cut of exercise \"" + exercise.name + "\" version " +
                   std::to_string(exercise.version) + " left of " + from.volume.Hex();
  return out;
}

}  // namespace

Status CheckPrepared(StoredBlobs& blobs, SceneRows& scenes_rows, const scene::Exercise& exercise) {
  scene::CavityTarget target = exercise.target;
  if (target.prepared.IsZero()) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(const auto scenes, scenes_rows.Scenes());
  if (std::ranges::find(scenes, target.prepared, &SceneRow::content) == scenes.end()) {
    return Status(Code::kNotFound,
                  "the target's prepared tooth, scene " + target.prepared.Hex() +
                      ", is not on this server; publish-exercise --prepared brings it",
                  "target.prepared_scene_sha256");
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto text, blobs.GetBlob(exercise.scene));
  ENAMEL_ASSIGN_OR_RETURN(const auto scene, scene::SceneFromJson(AsText(text)));
  ENAMEL_ASSIGN_OR_RETURN(const auto tooth, StoredVolume(blobs, scene.volume));
  return scene::LoadPreparedTarget(
      tooth, [&](const Sha256& hash) { return blobs.GetBlob(hash); }, target);
}

Result<ExerciseRow> PublishPrepared(Store& store, const SceneRow& scene,
                                    const std::filesystem::path& folder,
                                    const std::optional<Uuid>& cohort) {
  const std::filesystem::path document = folder / "exercise.json";
  ENAMEL_ASSIGN_OR_RETURN(const auto text, ReadFile(document, kMaxDocumentBytes));
  auto exercise = scene::ExerciseFromJson(AsText(text));
  if (!exercise.ok()) {
    return Status(exercise.status().code(), document.string() + ": " + exercise.status().field() +
                                                ": " + exercise.status().message());
  }
  if (exercise->scene != scene.content) {
    return Status(Code::kConflict,
                  folder.string() + " was made for another tooth: expected scene " +
                      scene.content.Hex() + " (" + scene.name + "), found " +
                      exercise->scene.Hex() + "; name the --scene and --voxel-um it was made with",
                  "scene");
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto prepared,
                          PublishScene(store.blobs, store.scenes, folder.string(), 0));
  if (exercise->target.prepared != prepared.content) {
    return Status(Code::kConflict,
                  document.string() + " names another prepared tooth than " +
                      (folder / "scene.json").string() + ": make the folder again",
                  "prepared");
  }
  ENAMEL_RETURN_IF_ERROR(CheckPrepared(store.blobs, store.scenes, *exercise));
  return PublishDocument(store.blobs, store.exercises, *exercise, cohort);
}

Status TargetFromReference(const std::filesystem::path& data, const FromReference& wanted) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(const auto row, NewestVersion(store->exercises, wanted.exercise));
  ENAMEL_ASSIGN_OR_RETURN(const auto reference, store->references.ReferenceFor(row.id));
  if (!reference) {
    return Status(Code::kNotFound, "\"" + row.name + "\" version " + std::to_string(row.version) +
                                       " has no reference; admin mark-reference makes one of a "
                                       "scored attempt");
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto cut_by, store->attempts.AttemptById(reference->attempt));
  if (wanted.anyway.empty()) {
    if (Status is_right = CheckReferenceCut(store->blobs, store->results, cut_by); !is_right.ok()) {
      return InsistWith(is_right, "--anyway REASON");
    }
  } else {
    ENAMEL_ASSIGN_OR_RETURN(const auto why, CheckedReason(wanted.anyway, "anyway"));
    ENAMEL_RETURN_IF_ERROR(
        store->audit.NoteAudit(kCommandLine, "exercise.target", row.id.Text(),
                               boost::json::serialize(boost::json::object{{"anyway", why}})));
  }
  ConsolePhases phases;
  phases.Begin("loading the tooth and what the reference left of it");
  ENAMEL_ASSIGN_OR_RETURN(const auto text, store->blobs.GetBlob(row.content));
  ENAMEL_ASSIGN_OR_RETURN(auto exercise, scene::ExerciseFromJson(AsText(text)));
  ENAMEL_ASSIGN_OR_RETURN(const auto scene_text, store->blobs.GetBlob(exercise.scene));
  ENAMEL_ASSIGN_OR_RETURN(const auto scene, scene::SceneFromJson(AsText(scene_text)));
  ENAMEL_ASSIGN_OR_RETURN(const auto tooth, StoredVolume(store->blobs, scene.volume));
  ENAMEL_ASSIGN_OR_RETURN(const auto result, store->results.ResultOf(reference->attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto cut, CutTooth(store->blobs, result.final_volume));

  ENAMEL_ASSIGN_OR_RETURN(const Sha256 volume, store->blobs.PutBlob(scene::EncodeVolume(cut)));
  const scene::Scene prepared = PreparedScene(scene, row, volume);
  ENAMEL_ASSIGN_OR_RETURN(const Sha256 content,
                          store->blobs.PutBlob(AsBytes(scene::ToJson(prepared))));
  const scene::CavityTarget before = exercise.target;
  phases.Begin("making the target");
  ENAMEL_ASSIGN_OR_RETURN(exercise.target,
                          scene::TargetFromPrepared(scene, tooth, std::move(cut), content,
                                                    wanted.tolerance_um.value_or(0)));
  if (!wanted.tolerance_um) {
    exercise.target.leeway_side_um = before.leeway_side_um;
    exercise.target.leeway_bottom_um = before.leeway_bottom_um;
    exercise.target.container_um = before.container_um;
  }
  ENAMEL_RETURN_IF_ERROR(
      store->scenes.PutScene({prepared.name, prepared.title, content, volume}, kCommandLine));
  phases.Begin("publishing " + exercise.name);
  ENAMEL_ASSIGN_OR_RETURN(const auto published,
                          PublishDocument(store->blobs, store->exercises, exercise, std::nullopt));
  Say("exercise \"{}\" version {}, id {}: its target is what version {}'s reference left\n",
      published.name, published.version, published.id.Text(), row.version);
  return Status::Ok();
}

void DeclareTargets(CommandGroup admin) {
  struct Wanted {
    std::filesystem::path data;
    std::string exercise, anyway;
    int32_t tolerance_um = -1;
  };
  auto [target, o] = Declare<Wanted>(
      admin, "target-from-reference",
      "Make the newest reference's result the target of the exercise's next version",
      [](const Wanted& w) {
        FromReference wanted{w.exercise, {}, w.anyway};
        if (w.tolerance_um >= 0) wanted.tolerance_um = w.tolerance_um;
        return TargetFromReference(w.data, wanted);
      });
  AddData(target, o.data);
  target->add_option("--exercise", o.exercise, "Its name; the newest version is used")->required();
  target
      ->add_option("--tolerance-um", o.tolerance_um,
                   "How far a cut may go beyond it; without: as it was")
      ->check(CLI::Range(0, 5'000));
  target->add_option("--anyway", o.anyway,
                     "Why, although the reference does not meet the exercise's target");
  target->footer(
      "Attempts of the new version are compared with that tooth, so it needs no reference. It is "
      "assigned\nto nobody yet; assignments of earlier versions stay with theirs.");
  AddExample(target, "--exercise class-1-molar-46");
}

}  // namespace enamel::server::app
