#pragma once

#include <string>

#include "common/base/result.h"

namespace enamel {

// What a PIN may be: 6 to 12 digits, not all the same, not counting up or down. Birthdays are
// allowed: whoever checks a PIN allows too few tries to exploit them. Errors: kInvalidInput, field
// "pin".
Status CheckPin(const std::string& pin);

}  // namespace enamel
