#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/import/import_tooth.h"

namespace enamel::import {

// The files that ImportSources names, read.
struct ReadSources {
  // Either the whole of one file, or surfaces by tissue.
  std::optional<mesh::Triangles> whole;
  std::array<std::optional<mesh::Triangles>, kLayers> surfaces;
  std::string provenance;           // each file with its SHA-256
  std::string name;                 // of the first file, without its extension
  std::vector<std::string> report;  // which part is which tissue, what was left out
};

// Reads each file once. Errors as ReadMeshInChild; kInvalidInput, field = the tissue, where a part
// is missing or its name is not unique (the message lists the parts of the file).
Result<ReadSources> Read(const ImportSources& sources, const std::filesystem::path& child);

}  // namespace enamel::import
