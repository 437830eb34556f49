#pragma once

#include <string>
#include <string_view>

#include "common/base/bytes.h"
#include "common/base/result.h"

namespace enamel {

// Lower-case hexadecimal.
std::string ToHex(ByteView data);
// Accepts either case. Errors: kInvalidInput on odd length or a character that is no digit.
Result<Bytes> FromHex(std::string_view hex);

}  // namespace enamel
