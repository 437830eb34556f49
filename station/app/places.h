#pragma once

#include <filesystem>

#include "common/base/result.h"

// Where the program is told to write: looked at before the work whose outcome goes there.
namespace enamel::station {

// Ok when `file` could be written now, or is empty (not asked for). `option` is what named it.
// Errors: kStorage with what to do.
Status CheckOutputFile(const std::filesystem::path& file, const char* option);
// The same for a folder, which need not exist yet.
Status CheckOutputFolder(const std::filesystem::path& folder, const char* option);

}  // namespace enamel::station
