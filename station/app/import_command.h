#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "common/mesh/units.h"

namespace enamel::station {

// 'enamel-station import': makes a scene's folder from mesh files (common/import/import_tooth.h).
struct ImportCommand {
  std::filesystem::path file, out;   // `file` may be empty when tissues name files
  std::string enamel, dentin, pulp;  // FILE, FILE#PART or a PART of `file`; may be empty
  int tooth = 0;                     // FDI number
  mesh::FileScale scale;
  std::string up = "auto", buccal = "auto";
  int voxel_um = 50;
  int bridge_um = 100;
};
// Prints the report to standard output and, on a terminal, progress to standard error.
Status ImportMesh(const ImportCommand& options);

}  // namespace enamel::station
