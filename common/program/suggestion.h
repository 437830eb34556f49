#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace enamel::program {

// After a parse that failed: "did you mean 'run'?" for a word that is nearly a command or an option
// of the command it follows: one or two letters wrong, missing, too many or exchanged. Empty: no
// word is, or two are equally near. Functions, any thread.
std::string Suggestion(const CLI::App& app);

}  // namespace enamel::program
