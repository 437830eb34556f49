#pragma once

#include <string>

#include "station/session/workplace.h"

namespace enamel::station {

// Fetches the exercise and the profile of these names, as a command line gives them. Requires: a
// sign-in. Errors also: kNotFound with the names there are.
Result<PreparedAttempt> PrepareByName(Workplace& workplace, const std::string& exercise,
                                      const std::string& profile);

}  // namespace enamel::station
