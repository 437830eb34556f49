#pragma once

#include <string_view>

#include "common/base/result.h"

namespace enamel::protocol {

// The release of Enamel that this program belongs to: "0.9.0".
std::string_view ThisRelease();

// Whether a server and a station of these releases work together: of one major version, at most one
// minor version apart (schemas/wire/README.md, "Releases"). Patches do not count. An empty `station`
// is a program that is no release of Enamel, and is admitted. Errors: kInvalidInput (no release),
// kVersion, both with field "release".
Status MayMeet(std::string_view server, std::string_view station);

}  // namespace enamel::protocol
