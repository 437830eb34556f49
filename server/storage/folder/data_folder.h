#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "server/storage/folder/disk.h"

namespace enamel::server {

// The server's folder, made where it is absent and fit to keep what identifies people: its owner's
// alone (mode 0700), writable, no unfinished restore unless it is `restoring`. Errors: kForbidden
// (others may look in, and it holds other things too; or this is root and the folder is another
// user's), kConflict (an unfinished restore), kStorage.
Status MakeDataFolder(const std::filesystem::path& folder, Disk& disk, bool restoring);

// The text of a mark in a data folder (folder_lock.h), without its line end. Errors: kNotFound,
// kStorage.
Result<std::string> ReadMark(const std::filesystem::path& file);

}  // namespace enamel::server
