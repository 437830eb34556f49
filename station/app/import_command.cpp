#include "station/app/import_command.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/import/scene_folder.h"
#include "common/program/log.h"
#include "common/program/output.h"
#include "station/app/command_line.h"

namespace enamel::station {
namespace {

constexpr char kFooter[] =
    R"(One surface, the outside of a crown or tooth; tissues are assumed by depth:
  enamel-station import crown.stl --tooth 46 --unit mm --out crown46
One surface per tissue, from files or from named parts of one (OBJ objects, groups
or materials, STL solids):
  enamel-station import --tooth 46 --enamel e.ply --dentin d.ply --pulp p.ply --unit mm --out t46
  enamel-station import tooth.obj --tooth 46 --enamel Enamel --dentin Dentin --unit mm --out t46
  enamel-station import crown.stl --tooth 46 --dentin inner.obj#Dentin --unit mm --out t46
A file whose parts are called enamel, dentin (root, cement) and pulp needs none of these.
Enamel may be an open dome, a shell with an inside or the outside of the whole crown;
dentin may be open below, and a hollow in it is the pulp where none is given. Surfaces
that gape or cross by up to --bridge-um are mended; more is refused with the figure.
A crown has at most 2000000 triangles and 256 MiB; reading takes at most 60 s and 4 GiB.
The folder gets scene.json, volume.envb and report.txt, which says what was repaired
and assumed; 'enamel-station simulate --scene FOLDER' cuts it.)";

// "+y of the file, 12 degrees off".
std::string AxisName(const dvec3& direction) {
  constexpr double kDegrees = 57.29577951308232;
  const dvec3 a = glm::abs(direction);
  const int k = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
  const std::string name = std::string(direction[k] > 0 ? "+" : "-") + "xyz"[k] + " of the file";
  const auto degrees = std::lround(std::acos(std::min(a[k], 1.0)) * kDegrees);
  return degrees == 0 ? name : name + ", " + std::to_string(degrees) + " degrees off";
}

std::string Words(import::Witness witness, int tooth) {
  switch (witness) {
    case import::Witness::kLikeness:
      return "its likeness to our tooth " + std::to_string(tooth);
    case import::Witness::kTaper:
      return "its taper to the edge";
    case import::Witness::kHollows:
      return "its hollows";
    case import::Witness::kHole:
      return "its hole, which is the gum";
    case import::Witness::kEnamel:
      return "the enamel's place on the dentin";
  }
  return "";
}

std::string OcclusalWords(const import::Placement& placement, int tooth) {
  const std::string axis = "occlusal direction " + AxisName(placement.up);
  if (placement.up_is == import::Placement::Up::kGiven) return axis + " (as given)";
  std::string by;
  for (import::Witness witness : placement.by)
    by += (by.empty() ? "by " : " and by ") + Words(witness, tooth);
  if (placement.up_is == import::Placement::Up::kFound)
    return axis + " (found " + by + "; if it is wrong, give another with --up)";
  return axis + " (a guess" + (by.empty() ? "" : " " + by) +
         ": look at the tooth, and give the direction with --up, for example --up=-y)";
}

std::string BuccalWords(const import::Placement& placement) {
  if (placement.buccal_given)
    return "buccal direction " + AxisName(placement.buccal) + " (as given)";
  return "buccal is taken to be at +y: a mesh does not say it (give its direction in the file with "
         "--buccal)";
}

}  // namespace

Status ImportMesh(const ImportCommand& options) {
  // First: reading and filling take up to a minute.
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFolder(options.out, "--out"));
  ENAMEL_RETURN_IF_ERROR(program::CheckNewIn(options.out, "scene.json", "--out"));
  import::ImportOptions import_options;
  import_options.scale = options.scale;
  import_options.tooth = options.tooth;
  import_options.up = options.up;
  import_options.buccal = options.buccal;
  import_options.voxel_nm = options.voxel_um * 1000;
  import_options.bridge_mm = options.bridge_um * 1e-3;
  const bool shows = ::isatty(STDERR_FILENO) != 0 && !program::LogIsJson();
  if (shows) {
    import_options.phase = [](std::string_view phase) {
      std::fprintf(stderr, "\r\033[K%.*s", static_cast<int>(phase.size()), phase.data());
    };
    import_options.progress = [](double done) {
      std::fprintf(stderr, "\r\033[Kfilling the volume %3.0f %%", 100 * done);
    };
  }
  // Separate lines when output goes to a file, so that its reader sees progress too.
  if (!shows && !program::LogIsJson()) {
    import_options.phase = [](std::string_view phase) {
      std::fprintf(stderr, "%.*s\n", static_cast<int>(phase.size()), phase.data());
    };
  }
  const import::ImportSources sources{options.file, {options.enamel, options.dentin, options.pulp}};
  auto imported = import::ImportTooth(sources, import_options);
  if (shows) std::fprintf(stderr, "\r\033[K");
  if (!imported.ok()) {
    const Status& why = imported.status();
    if (why.field() == "bridge_um") return Status(why.code(), why.message() + " with --bridge-um");
    return why;
  }
  const dvec3& size = imported->size_mm;
  imported->report.push_back("size " + mesh::Fixed(size.x) + " x " + mesh::Fixed(size.y) + " x " +
                             mesh::Fixed(size.z) + " mm");
  imported->report.push_back(OcclusalWords(imported->placement, options.tooth));
  imported->report.push_back(BuccalWords(imported->placement));
  ENAMEL_RETURN_IF_ERROR(import::WriteSceneFolder(options.out, *imported));
  for (const std::string& line : imported->report) std::printf("%s\n", line.c_str());
  std::printf("scene '%s' written to %s\n", imported->scene.name.c_str(), options.out.c_str());
  return Status::Ok();
}

void DeclareImport(CommandGroup group) {
  auto [command, options] = Declare<ImportCommand>(
      group, "import", "Make a scene of a real tooth's meshes (STL, PLY, OBJ, OFF)", ImportMesh);
  command->footer(kFooter);
  command->add_option("file", options.file, "Mesh of the whole, or the one that has the parts");
  command->add_option("--enamel", options.enamel,
                      "Its surface: FILE, FILE#PART, or PART of 'file'");
  command->add_option("--dentin", options.dentin, "The same");
  command->add_option("--pulp", options.pulp, "The same");
  command
      ->add_option("--tooth", options.tooth,
                   "Its FDI number (ISO 3950), 46 for a lower right first molar: says which side "
                   "is mesial")
      ->required();
  AddScale(command, options.scale);
  command->add_option("--out", options.out, "Folder for the scene")->required();
  command->add_option("--voxel-um", options.voxel_um, "Edge of a voxel")
      ->check(CLI::Range(10, 500))
      ->capture_default_str();
  command
      ->add_option("--up", options.up,
                   "Occlusal direction in the file: auto, +x to -z, or three numbers as 0.2,0,-1")
      ->capture_default_str();
  command->add_option("--buccal", options.buccal, "Buccal (labial) direction in the file: the same")
      ->capture_default_str();
  command
      ->add_option("--bridge-um", options.bridge_um,
                   "Gaps and crossings between tissues that are mended")
      ->check(CLI::Range(0, 500))
      ->capture_default_str();
}

}  // namespace enamel::station
