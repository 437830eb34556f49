#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"

namespace enamel::program {

// Replaces the running program by `name` beside it: the same process, environment and streams, and
// the other's exit code. Returns only where that failed. Errors: kNotFound, naming the file.
Status ReplaceBy(const std::string& name, std::vector<std::string> arguments);

}  // namespace enamel::program
