#pragma once

#include <filesystem>

#include "common/base/result.h"

// `init`: a data folder before the first `serve`.
namespace enamel::server::app {

// Creates the missing parts of the folder (mode 0700), its database and its identity, and prints
// the result. `serve` does the same by itself.
Status InitData(const std::filesystem::path& folder);

struct CommandGroup;
// On the command line (command_line.h).
void DeclareInit(CommandGroup root);

}  // namespace enamel::server::app
