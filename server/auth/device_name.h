#pragma once

#include <string>
#include <string_view>

namespace enamel::server::auth {

// A browser's name for itself, reduced to what helps somebody recognise it: "Firefox on Linux", "a
// browser on Windows", "Chrome"; "" if it names neither. Returns only our own words, never the sent
// text, of which the first 512 bytes count. Pure function, any thread.
std::string DeviceName(std::string_view user_agent);

}  // namespace enamel::server::auth
