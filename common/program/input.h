#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

// What a command reads beside its options.
namespace enamel::program {

// The text of `file`, or of standard input where `file` is "-": a file that only root may read gets
// to a command of another user that way. Errors: those of ReadFile.
Result<std::string> ReadInput(const std::filesystem::path& file, size_t max_bytes);

}  // namespace enamel::program
