#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "common/base/file.h"
#include "common/import/prepared_tooth.h"
#include "common/import/scene_folder.h"
#include "common/program/output.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/prepared_target.h"
#include "station/app/command_line.h"

namespace enamel::station {
namespace {

constexpr char kFooter[] =
    R"(A tooth that a dentist prepared, as a scan (STL, PLY, OBJ, OFF), becomes an exercise:
  enamel-station target prepared.stl --unit mm --scene builtin:molar --out molar-crown
  enamel-server admin publish-exercise --data DIR --scene builtin:molar --prepared molar-crown
The scan is laid on the tooth by what was not prepared, from whichever side it was
scanned, with or without the root. What it then lacks of the tooth is what has to go.
How well it lies there is printed; a scan of another tooth, a mirrored one, or one in
which the preparation is not whole is refused with the figures. A block or another
shape that fits itself in several ways has to lie nearly right in its file: --placed.
The folder gets the prepared tooth as a scene, exercise.json and report.txt; the title,
the text, the bur and the rubric in exercise.json may be changed before it is published.
--scene and --voxel-um are those of the tooth that the exercise is published on.)";

struct TargetCommand {
  std::filesystem::path file, out;
  std::string scene, name;
  mesh::FileScale scale;
  int voxel_um = 50, tolerance_um = 250;
  bool placed = false;
};

Status MakeTarget(const TargetCommand& o) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFolder(o.out, "--out"));
  ENAMEL_ASSIGN_OR_RETURN(const auto tooth, import::LoadScene(o.scene, o.voxel_um * 1000));
  import::PreparedOptions options;
  options.scale = o.scale;
  options.placed = o.placed;
  ENAMEL_ASSIGN_OR_RETURN(auto taken,
                          import::TakePrepared(tooth.scene, tooth.volume, o.file, options));
  const Sha256 scene = HashSha256(AsBytes(scene::ToJson(tooth.scene)));
  const Sha256 prepared = HashSha256(AsBytes(scene::ToJson(taken.prepared.scene)));
  ENAMEL_ASSIGN_OR_RETURN(
      const auto target, scene::TargetFromPrepared(tooth.scene, tooth.volume, taken.prepared.volume,
                                                   prepared, o.tolerance_um));
  scene::Exercise exercise = scene::PreparedExercise(tooth.scene, scene, target);
  if (!o.name.empty()) exercise.name = o.name;
  const std::string document = scene::ToJson(exercise);
  // Reads it back as any reader will: an invalid name is refused here.
  ENAMEL_RETURN_IF_ERROR(scene::ExerciseFromJson(document).status());
  ENAMEL_RETURN_IF_ERROR(import::WriteSceneFolder(o.out, taken.prepared));
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(o.out / "exercise.json", AsBytes(document)));
  for (const std::string& line : taken.prepared.report) std::printf("%s\n", line.c_str());
  std::printf("exercise '%s' written to %s\n", exercise.name.c_str(), o.out.c_str());
  return Status::Ok();
}

}  // namespace

void DeclareTarget(CommandGroup group) {
  auto [command, o] = Declare<TargetCommand>(
      group, "target", "Make an exercise of a scan of a prepared tooth", MakeTarget);
  command->footer(kFooter);
  command->add_option("file", o.file, "The scan")->required();
  AddScale(command, o.scale);
  command
      ->add_option("--scene", o.scene, "The tooth: a scene folder, or builtin:molar and the like")
      ->required();
  command->add_option("--out", o.out, "Folder for the exercise")->required();
  command->add_option("--voxel-um", o.voxel_um, "Voxel size of a built-in scene")
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  command
      ->add_option("--tolerance-um", o.tolerance_um,
                   "How far a cut may go beyond the scan's before tissue that must stay begins")
      ->check(CLI::Range(0, 5'000))
      ->capture_default_str();
  command->add_option("--name", o.name, "Of the exercise; without: prepared-SCENE");
  command->add_flag("--placed", o.placed, "The scan is nearly in place on the tooth already");
}

}  // namespace enamel::station
