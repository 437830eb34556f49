#pragma once

#include <initializer_list>
#include <string_view>

namespace CLI {
class App;
}

namespace enamel::program {

// Ends a command's help with command lines of it, each on a line of its own: `arguments` is what
// somebody types after the command's words. After its footer is set. Every command has one, and
// tests parse it (tests/support/every_command.h).
void AddExamples(CLI::App& command, std::initializer_list<std::string_view> arguments);

}  // namespace enamel::program
