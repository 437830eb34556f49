#pragma once

#include <filesystem>

#include "common/base/result.h"

namespace enamel::station {

// Creates `folder` and missing parents. `folder` itself is for its owner only (0700), because a
// station's data folder holds its key and people's work. An existing folder keeps its mode. Errors:
// kStorage with what to do.
Status MakePrivateFolder(const std::filesystem::path& folder);

}  // namespace enamel::station
