#pragma once

#include <string>

#include "common/language/words.h"

namespace enamel::station::desk {

// Why a password cannot replace the one-time one, by the rules that need no server; empty: it may.
// Any thread.
std::string ProblemOfPassword(const language::Words& words, const std::string& one_time,
                              const std::string& chosen, const std::string& again);

}  // namespace enamel::station::desk
