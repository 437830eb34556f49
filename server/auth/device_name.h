#pragma once

#include <string>
#include <string_view>

namespace enamel::server::auth {

// What a browser says it is, reduced to what helps somebody recognise it: "Firefox on Linux",
// "a browser on Windows", "Chrome"; "" of what says neither. Our own words only, never what was
// sent, of which the first 512 bytes count. Pure function, any thread.
std::string DeviceName(std::string_view user_agent);

}  // namespace enamel::server::auth
