#pragma once

#include <string>

namespace enamel::server {

// Logs what a database says of a failure. While it is away it is asked many times a second, so the
// same words come once a minute, with their number (RepeatLog). Thread safety: any thread.
void WarnOfDatabase(const std::string& words);

}  // namespace enamel::server
