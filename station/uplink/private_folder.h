#pragma once

#include <filesystem>

#include "common/base/result.h"

namespace enamel::station {

// Makes `folder` and what is missing above it; `folder` itself for its owner only (0700), as a
// station's data folder holds its key and what people did. One that exists keeps its mode.
// Errors: kStorage with what to do.
Status MakePrivateFolder(const std::filesystem::path& folder);

}  // namespace enamel::station
