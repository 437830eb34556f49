#include "station/app/command_line.h"

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "common/program/log.h"

namespace enamel::station {

int Finish(const Status& status) {
  if (status.ok()) return 0;
  // So that the reason follows the output when both go to one file.
  std::fflush(stdout);
  program::SayError(status.message());
  return kFailed;
}

std::vector<const char*> WithOpen(int argc, const char* const* argv, const CLI::App& app) {
  std::vector<const char*> out(argv, argv + argc);
  for (size_t i = 1; i < out.size(); ++i) {
    const std::string_view word = out[i];
    if (!word.starts_with("-")) break;  // a command, or none that there is
    const size_t equals = word.find('=');
    const CLI::Option* own = app.get_option_no_throw(std::string(word.substr(0, equals)));
    if (own == nullptr) {
      out.insert(out.begin() + static_cast<std::ptrdiff_t>(i), "open");
      break;
    }
    if (equals == word.npos && own->get_items_expected_max() > 0) ++i;  // over its value
  }
  return out;
}

void AddCpu(CLI::App* cmd, int& cpu) {
  cmd->add_option("--cpu", cpu, "Bind the haptic loop to this processor, 0 the first")
      ->check(CLI::Range(0, 1023));
}

std::string Environment(const char* name) {
  const char* set = std::getenv(name);
  return set == nullptr ? "" : set;
}

}  // namespace enamel::station
