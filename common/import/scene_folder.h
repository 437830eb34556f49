#pragma once

#include <filesystem>
#include <string_view>

#include "common/import/import_tooth.h"
#include "common/scene/builtin/builtin.h"

namespace enamel::import {

// A scene on disk: scene.json (canonical), volume.envb, and report.txt for people.
// Creates the folder; replaces files of an earlier import. Errors: kStorage.
Status WriteSceneFolder(const std::filesystem::path& folder, const ImportedScene& imported);

struct SceneFolder {
  scene::Scene scene;
  cutting::Volume volume;
  Bytes scene_json;  // as stored: their SHA-256 is the scene's address
  Bytes volume_blob;
};
// Errors: kNotFound, whatever is wrong in a document, kConflict when volume and scene do not belong
// together.
Result<SceneFolder> LoadSceneFolder(const std::filesystem::path& folder);

inline constexpr std::string_view kBuiltin = "builtin:";

// The scene that a command line names: "builtin:NAME", made with this voxel in at most `max_bytes`,
// or such a folder. Errors: the same, and the builder's.
Result<scene::BuiltScene> LoadScene(std::string_view source, int32_t voxel_nm,
                                    size_t max_bytes = scene::kDefaultSceneBytes);

}  // namespace enamel::import
