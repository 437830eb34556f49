#pragma once

#include <string>

#include "common/base/result.h"
#include "common/language/words.h"
#include "common/scene/delay.h"

namespace enamel::station::desk {

// A refusal as a person at the chair reads it, in their language: the event, then the remedy.
// Refusals that few people meet have one sentence for each code; the log has the details.
std::string ProblemText(const language::Words& words, const Status& status);
// Why an attempt that the server has is not scored (AttemptProgress::problem).
std::string NoScoreText(const language::Words& words, const Status& problem);

// Why a device's force is softer than it could be; empty: it is not.
std::string SofterText(const language::Words& words, scene::DelayUsed::From from,
                       const std::string& device);

}  // namespace enamel::station::desk
