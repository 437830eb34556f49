#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace enamel::program {

// After a parse that failed: "did you mean 'run'?" for a word that is nearly a command or an option
// of the command it follows: one or two letters wrong, missing, too many or exchanged. Empty: no
// word is, or two are equally near. Functions, any thread.
std::string Suggestion(const CLI::App& app);

// The first word that stands where a command was expected and is none. Empty: there is none.
std::string UnknownCommand(const CLI::App& app);

// How a program ends after a parse that threw: prints help or the error, with the suggestion, and
// gives the exit code, 0 where help or the version was asked for, else 2. `json`: errors as a line
// of the log.
int EndOfParse(const CLI::App& app, const CLI::ParseError& error, bool json);

}  // namespace enamel::program
