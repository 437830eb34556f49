#pragma once

#include <filesystem>
#include <optional>

#include "common/base/result.h"
#include "server/storage/folder/database_file.h"

namespace enamel::server {

// Deletes all that a school has, wherever it is: the keys first, so that no recording can be read
// from then on, then rows, blobs and the folder; also what is damaged. There is no way back but a
// backup. `database`: where it is; none: in the folder. What is in S3 stores has to have a prefix
// of its own. After a failure again.
// Errors: kUnavailable, field kServerHasIt (a server has not let go of it); kConflict (no prefix of
// its own); those of the stores.
Status DeleteStore(const std::filesystem::path& folder,
                   const std::optional<DatabaseFile>& database);

inline constexpr char kServerHasIt[] = "server";

}  // namespace enamel::server
