#include "station/app/lab_command.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "common/program/beside.h"

namespace enamel::station {
namespace {

struct Renamed {
  std::string_view here;
  std::vector<std::string> lab;
};

const std::vector<Renamed>& Commands() {
  // Names from before the lab was a separate program, for scripts and notes.
  static const std::vector<Renamed> all = {{"qualify", {"qualify"}},
                                           {"fit-damping", {"fit-damping"}},
                                           {"explain", {"explain"}},
                                           {"frame-bench", {"bench", "frames"}}};
  return all;
}

// Position of the command, behind the program's own options; argc: none.
int CommandAt(int argc, const char* const* argv) {
  constexpr std::string_view kWithValue[] = {"--config", "--log-format", "--log-level"};
  int at = 1;
  while (at < argc && argv[at][0] == '-') {
    at += std::ranges::find(kWithValue, std::string_view(argv[at])) != std::end(kWithValue) ? 2 : 1;
  }
  return std::min(at, argc);
}

const Renamed* Find(int argc, const char* const* argv) {
  const int at = CommandAt(argc, argv);
  if (at == argc) return nullptr;
  auto found = std::ranges::find(Commands(), std::string_view(argv[at]), &Renamed::here);
  return found == Commands().end() ? nullptr : &*found;
}

}  // namespace

bool IsLabCommand(int argc, const char* const* argv) { return Find(argc, argv) != nullptr; }

Status RunLabCommand(int argc, const char* const* argv) {
  const Renamed& command = *Find(argc, argv);
  const int at = CommandAt(argc, argv);
  std::vector<std::string> arguments(argv + 1, argv + at);
  arguments.insert(arguments.end(), command.lab.begin(), command.lab.end());
  arguments.insert(arguments.end(), argv + at + 1, argv + argc);
  // Returns only on failure; otherwise this process becomes the lab, with its exit code.
  Status failed = program::ReplaceBy("enamel-lab", std::move(arguments));
  return Status(failed.code(),
                "'" + std::string(command.here) + "' is a command of enamel-lab, which is not " +
                    "installed here (" + failed.message() +
                    "): 'cmake --install BUILD --component lab' installs it beside this program, "
                    "'ninja -C BUILD enamel-lab' builds it");
}

}  // namespace enamel::station
