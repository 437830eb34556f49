#pragma once

#include <string>

#include "station/session/workplace.h"

namespace enamel::station {

// The exercise named on a command line.
struct WantedExercise {
  std::string name;
  Uuid assignment;  // zero: any that can be begun
  // The device that will hold the tool; kNotTold if not known yet. The server decides whether it is
  // on the school's list of devices.
  Hand hand = {};
};

// Chooses the assignment of the exercise that can be begun here: the first due of those that admit
// the hand and allow an attempt. Errors: kNotFound with the existing names or assignments;
// kForbidden with the reasons why none can be begun now, each once; kForbidden, field "hand", when
// one is an open exam that does not admit the hand, so that an exam is not avoided unless another
// assignment is named.
Result<Catalogue::Exercise> ChooseByName(const std::vector<Catalogue::Exercise>& exercises,
                                         const WantedExercise& wanted);

// Fetches the exercise and the profile of this name. Requires: a sign-in. Errors also:
// ChooseByName's, kNotFound for a profile.
Result<PreparedAttempt> PrepareByName(Workplace& workplace, const WantedExercise& wanted,
                                      const std::string& profile);

}  // namespace enamel::station
