#pragma once

#include <string>

#include "common/language/words.h"
#include "station/desk/hand_alignment.h"
#include "station/session/unrecorded_run.h"

namespace enamel::station::desk {

// How long the bur turns while a device is tried; and how long somebody may look at the block
// without turning it, before the window goes back to the exercise.
inline constexpr double kWarmUp_s = 10, kWarmUpWait_s = 60;

// The practice block, with bur, handpiece, law, rate and device profile of an exercise: it feels
// and runs as that will. Needs no server. Errors: those of CompilePlan.
Result<PreparedAttempt> WarmUpFor(const PreparedAttempt& exercise);

// "Device tried for 10 s: the computer kept up, largest force 2.1 N."
std::string WarmUpText(const language::Words& words, const UnrecordedRun::Found& found);

// How to move the handpiece for the match, then what was found. Empty: nobody asked for one.
std::string AlignmentText(const language::Words& words, const HandAlignment& alignment);

}  // namespace enamel::station::desk
