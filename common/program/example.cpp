#include "common/program/example.h"

#include <CLI/CLI.hpp>
#include <string>

namespace enamel::program {

void AddExamples(CLI::App& command, std::initializer_list<std::string_view> arguments) {
  std::string words;
  for (const CLI::App* app = &command; app != nullptr; app = app->get_parent()) {
    words.insert(0, app->get_name() + " ");
  }
  std::string text = command.get_footer();
  if (!text.empty()) text += "\n\n";
  text += arguments.size() == 1 ? "Example:" : "Examples:";
  for (const std::string_view each : arguments) {
    const std::string line = "\n  " + words + std::string(each);
    text += line.substr(0, line.find_last_not_of(' ') + 1);
  }
  command.footer(text);
}

}  // namespace enamel::program
