#pragma once

#include <filesystem>
#include <optional>

#include "common/base/result.h"
#include "server/storage/folder/database_file.h"

namespace enamel::server {

// Deletes all data of a school, wherever it is, even if damaged: the keys first, so that no
// recording can be read from then on, then rows, blobs and the folder. Only a backup brings it
// back. `database`: its place; none: in the folder. Data in S3 stores must have a prefix of its
// own. After a failure, call it again. Errors: kUnavailable, field kServerHasIt (a server still
// serves it); kConflict (no prefix of its own); those of the stores.
Status DeleteStore(const std::filesystem::path& folder,
                   const std::optional<DatabaseFile>& database);

inline constexpr char kServerHasIt[] = "server";

}  // namespace enamel::server
