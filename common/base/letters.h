#pragma once

#include <string>
#include <string_view>

#include "common/base/bytes.h"

namespace enamel {

// For refusals: what begins with `found` instead of `wanted`. Every binary format of this project
// begins with "EN" and two letters of its own. `wanted` "ENah", `found` "ENhd": "expected it to
// begin with ENah, found ENhd: it is of another kind, or of an earlier Enamel, which this program
// cannot read". Thread safety: any thread.
std::string OtherLetters(std::string_view wanted, ByteView found);

}  // namespace enamel
