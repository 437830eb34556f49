#include "common/import/scene_folder.h"

#include <system_error>

#include "common/base/file.h"
#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"

namespace enamel::import {
namespace {

constexpr const char* kSceneFile = "scene.json";
constexpr const char* kVolumeFile = "volume.envb";
constexpr const char* kReportFile = "report.txt";

Status In(const std::filesystem::path& file, const Status& status) {
  return Status(status.code(), file.string() + ": " + status.message(), status.field());
}

}  // namespace

Status WriteSceneFolder(const std::filesystem::path& folder, const ImportedScene& imported) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return Status(Code::kStorage,
                  "cannot make the folder " + folder.string() + ": " + error.message());
  std::string report;
  for (const std::string& line : imported.report) report += line + "\n";
  ENAMEL_RETURN_IF_ERROR(
      WriteFileDurably(folder / kVolumeFile, scene::EncodeVolume(imported.volume)));
  // The document last: it names the volume, and a folder cut off in between still reads as the old
  // scene or is found by its hash.
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(folder / kReportFile, AsBytes(report)));
  return WriteFileDurably(folder / kSceneFile, AsBytes(scene::ToJson(imported.scene)));
}

Result<SceneFolder> LoadSceneFolder(const std::filesystem::path& folder) {
  SceneFolder out;
  ENAMEL_ASSIGN_OR_RETURN(Bytes json, ReadFile(folder / kSceneFile, size_t{1} << 20));
  Result<scene::Scene> scene = scene::SceneFromJson(AsText(json));
  if (!scene.ok()) return In(folder / kSceneFile, scene.status());
  ENAMEL_ASSIGN_OR_RETURN(Bytes blob, ReadFile(folder / kVolumeFile));
  if (HashSha256(blob) != scene->volume) {
    return Status(Code::kConflict, (folder / kVolumeFile).string() + " is not the volume that " +
                                       kSceneFile + " names: import the tooth again");
  }
  Result<cutting::Volume> volume = scene::DecodeVolume(blob);
  if (!volume.ok()) return In(folder / kVolumeFile, volume.status());
  if (volume->spec().voxel_nm != scene->voxel_nm) {
    return Status(Code::kConflict,
                  folder.string() + ": scene and volume disagree about the voxel size");
  }
  out.scene = std::move(*scene);
  out.volume = std::move(*volume);
  out.scene_json = std::move(json);
  out.volume_blob = std::move(blob);
  return out;
}

Result<scene::BuiltScene> LoadScene(std::string_view source, int32_t voxel_nm, size_t max_bytes) {
  if (source.starts_with(kBuiltin))
    return scene::BuildBuiltinScene(source.substr(kBuiltin.size()), voxel_nm, max_bytes);
  ENAMEL_ASSIGN_OR_RETURN(auto folder, LoadSceneFolder(source));
  return scene::BuiltScene{std::move(folder.scene), std::move(folder.volume)};
}

}  // namespace enamel::import
