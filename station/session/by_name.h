#pragma once

#include <string>

#include "station/session/workplace.h"

namespace enamel::station {

// What a command line asks for.
struct WantedExercise {
  std::string name;
  Uuid assignment;  // zero: whichever can be begun
  // What will hold the tool; kNotTold where it is not known yet. Whether a device is on the school's
  // list is for the server to say.
  Hand hand = {};
};

// The exercise that an attempt can be begun at: of several assignments of it the one that is due first,
// admits the hand and allows an attempt. Errors: kNotFound with the names there are, or the
// assignments; kForbidden with why none of them can be begun here and now, each reason once, or,
// field "hand", where one of them is an open exam that does not admit the hand: it is not dodged
// without another being named.
Result<Catalogue::Exercise> ChooseByName(const std::vector<Catalogue::Exercise>& exercises,
                                         const WantedExercise& wanted);

// Fetches what is wanted and the profile of this name. Requires: a sign-in. Errors also:
// ChooseByName's, kNotFound for a profile.
Result<PreparedAttempt> PrepareByName(Workplace& workplace, const WantedExercise& wanted,
                                      const std::string& profile);

}  // namespace enamel::station
