#pragma once

#include <string>

#include "station/session/workplace.h"

namespace enamel::station {

// The exercise of this name that an attempt can be begun at: of several assignments of it the one
// that is due first and allows an attempt. Errors: kNotFound with the names there are; kForbidden
// with why none of them can be begun here and now.
Result<Catalogue::Exercise> ChooseByName(const std::vector<Catalogue::Exercise>& exercises,
                                         const std::string& name);

// Fetches the exercise and the profile of these names, as a command line gives them. Requires: a
// sign-in. Errors also: ChooseByName's, kNotFound for a profile.
Result<PreparedAttempt> PrepareByName(Workplace& workplace, const std::string& exercise,
                                      const std::string& profile);

}  // namespace enamel::station
