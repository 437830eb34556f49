#pragma once

#include <boost/json/fwd.hpp>
#include <filesystem>
#include <string>

#include "common/base/result.h"

// The place where a program writes its result, checked before the work begins.
namespace enamel::program {

// Ok when `file` could be written now, or is empty (not asked for). `option` is what named it.
// Errors: kStorage with what to do.
Status CheckOutputFile(const std::filesystem::path& file, const char* option);
// The same for a folder, which need not exist yet.
Status CheckOutputFolder(const std::filesystem::path& folder, const char* option);
// Before a command makes a folder's files: `folder` must not have `file` yet. kConflict: it has, and
// nothing is overwritten.
Status CheckNewIn(const std::filesystem::path& folder, const char* file, const char* option);
// JSON that people read, too: a number is written as 94.0, where boost::json writes 9.4E1. Reads back
// as the same value.
std::string JsonText(const boost::json::value& value);
// Writes an object as one line of such JSON. An empty `file` means: write nothing.
Status WriteJsonFile(const std::filesystem::path& file, const boost::json::object& object);

}  // namespace enamel::program
