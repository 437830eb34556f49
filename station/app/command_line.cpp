#include "station/app/command_line.h"

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "common/program/log.h"
#include "station/devices/operators.h"

namespace enamel::station {
namespace {

constexpr char kFooter[] = R"(A first attempt, with a server on the same machine:
  enamel-server admin enrol-code --data SERVER_DATA        # prints CODE@FINGERPRINT
  enamel-station enrol --server 127.0.0.1:8443 --code CODE@FINGERPRINT
  enamel-station                                           # the window; sign in there
                                                           # it has the options of 'open'
or without a window, with a simulated hand:
  ENAMEL_PASSWORD=... enamel-station run --user LOGIN \
      --exercise NAME --profile phantom_desktop --operator student
Without any server:
  enamel-station simulate --profile phantom_desktop --operator dentist
To send what was recorded while the server was away:
  enamel-station upload
After a crash or a power cut, continue where the recording ends, or end it there:
  ENAMEL_PASSWORD=... enamel-station run --user LOGIN --resume last
  enamel-station spool close last
To work for hours without the server, with a PIN of your own:
  ENAMEL_PASSWORD=... ENAMEL_PIN=... enamel-station reserve --user LOGIN --exercise NAME --profile NAME
  ENAMEL_PIN=... enamel-station run --reserved ID
  ENAMEL_PIN=... enamel-station reserve --give-back ID
Laws, cutting and this computer are measured by enamel-lab; 'enamel-lab --help' shows how.
Settings: command line before environment (ENAMEL_STATION_ and the option's name, as
ENAMEL_STATION_UPLINK_KBIT) before a file (--config FILE); schemas/station_settings.md.
Exit codes: 0 done, 1 failed (the reason is on standard error), 2 wrong command line,
3 recorded and safe on this station, but not on the server yet, or left to be resumed.)";

}  // namespace

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

void AddScale(CLI::App* cmd, mesh::FileScale& scale) {
  cmd->add_option("--unit", scale.unit, "Unit of the coordinates")
      ->check(CLI::IsMember({"mm", "um", "cm", "m", "inch"}))
      ->required();
  cmd->add_option("--scale", scale.factor,
                  "How many of this unit a coordinate of 1 is, for files on another scale")
      ->capture_default_str();
  cmd->add_option("--longest-mm", scale.longest_mm,
                  "Longest side of the box around everything in the file, 3 to 40 mm; --unit and "
                  "--scale do not count then");
}

void AddOperator(CLI::App* cmd, std::string& name) {
  std::vector<std::string> names;
  for (const OperatorPreset& preset : OperatorPresets()) names.emplace_back(preset.name);
  cmd->add_option("--operator", name, "Simulated person who holds the device")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
}

std::string Environment(const char* name) {
  const char* set = std::getenv(name);
  return set == nullptr ? "" : set;
}

OpenCommand DeclareCommands(CommandGroup group) {
  const OpenCommand open = DeclareOpen(group);
  for (auto declare :
       {DeclareEnrol, DeclareRun, DeclareSpool, DeclareReserve, DeclareReplay, DeclareVerify,
        DeclareImport, DeclareTarget, DeclareSimulate, DeclareLists, DeclareDeviceCommands}) {
    declare(group);
  }
  // After the commands, which would inherit it.
  group.app.footer(kFooter);
  return open;
}

}  // namespace enamel::station
