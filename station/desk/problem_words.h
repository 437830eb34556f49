#pragma once

#include <string>

#include "common/base/result.h"
#include "common/language/words.h"
#include "common/scene/delay.h"
#include "station/loop/tick_loop.h"

namespace enamel::station::desk {

// A refusal as a person at the chair reads it, in their language: the event, then the remedy.
// Refusals that few people meet have one sentence for each code; the log has the details.
std::string ProblemText(const language::Words& words, const Status& status);
// Why an attempt that the server has is not scored (AttemptProgress::problem).
std::string NoScoreText(const language::Words& words, const Status& problem);

// Key of the message for a fault at the chair; its English is FaultText's. Empty for none.
const char* FaultKey(Fault fault);
// Why the force is off and what to do, as a sentence of the window. `device`: why its driver cannot reach
// it (Device::problem), which is more precise than the fault where it names a cause.
// `lacks_realtime`: the loop has no real-time rights, so that a late tick is no wonder. Empty for none.
std::string FaultSentence(const language::Words& words, Fault fault, const Status& device,
                          bool lacks_realtime);

// Why a device's force is softer than it could be; empty: it is not.
std::string SofterText(const language::Words& words, scene::DelayUsed::From from,
                       const std::string& device);

}  // namespace enamel::station::desk
