#pragma once

#include <filesystem>

#include "common/import/import_tooth.h"

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

}  // namespace enamel::import
