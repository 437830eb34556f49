#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/program/log.h"
#include "common/program/suggestion.h"
#include "common/program/version.h"
#include "station/app/command_line.h"
#include "station/app/device_commands.h"
#include "station/app/lab_command.h"
#include "station/app/spool_command.h"
#include "station/uplink/policy_file.h"

// enamel-station: its commands.
namespace {

using namespace enamel;
using namespace enamel::station;

constexpr char kName[] = "enamel-station", kPrefix[] = "ENAMEL_STATION_";
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
Laws, cutting and this computer are measured by enamel-lab; 'enamel-lab --help' shows how. The
older names qualify, fit-damping, explain and frame-bench still start it from here.
Settings: command line before environment (ENAMEL_STATION_ and the option's name, as
ENAMEL_STATION_UPLINK_KBIT) before a file (--config FILE); schemas/station_settings.md.
Exit codes: 0 done, 1 failed (the reason is on standard error), 2 wrong command line,
3 recorded and safe on this station, but not on the server yet, or left to be resumed.)";

std::string DefaultData() {
  if (const char* set = std::getenv("ENAMEL_STATION_DATA")) return set;
  if (const char* home = std::getenv("HOME"))
    return std::string(home) + "/.local/share/enamel-station";
  return "enamel-station-data";
}

std::vector<program::PolicySetting> PolicyIn(const std::filesystem::path& data) {
  const protocol::Policy policy = LoadPolicy(data);
  std::vector<program::PolicySetting> out;
  for (const auto& setting : policy.settings()) {
    out.push_back({setting.name(), setting.value(), setting.fixed()});
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  // Output that nobody reads any more must not end a program that holds a force.
  std::signal(SIGPIPE, SIG_IGN);
  const bool json = program::AsksForJson(argc, argv, kPrefix);
  (void)program::SetUpLog({.format = json ? "json" : "text", .name = kName});
  // Before parsing, which does not know the lab's options.
  if (IsLabCommand(argc, argv)) return Finish(RunLabCommand(argc, argv));
  CLI::App app("enamel-station: cut virtual teeth; every tick is recorded and sent to the server.");
  app.footer("'enamel-station --help' shows a first attempt, and what exit codes mean.");
  app.require_subcommand(0, 1);
  app.set_version_flag("--version", program::VersionText(kName));
  int exit_code = 0;
  program::CommandSettings settings(app, {.program = kName,
                                          .prefix = kPrefix,
                                          .system_file = "/etc/enamel/station.toml",
                                          .policy = PolicyIn});
  WorkplaceSettings place;
  place.data = DefaultData();
  const CommandGroup group{app, place, settings, exit_code};
  const OpenCommand open = DeclareOpen(group);
  DeclareEnrol(group);
  DeclareRun(group);
  SpoolCommand spool;
  AddSpoolCommands(app, spool, place, [&](const Status& status) { exit_code = Finish(status); });
  for (auto declare : {DeclareReserve, DeclareReplay, DeclareVerify, DeclareImport, DeclareTarget,
                       DeclareSimulate, DeclareLists}) {
    declare(group);
  }
  RegisterDeviceCommands(app, DefaultData(), Finish, &exit_code, settings.own());
  // After the commands are declared, since a subcommand inherits the footer set at that time.
  app.footer(kFooter);
  settings.Add();
  try {
    const std::vector<const char*> arguments = WithOpen(argc, argv, app);
    app.parse(static_cast<int>(arguments.size()), arguments.data());
    // As started from a desktop's icon: without a subcommand the window opens.
    if (app.get_subcommands().empty()) {
      Status set = settings.Apply(*open.cmd);
      exit_code = Finish(set.ok() ? open.run() : set);
    }
  } catch (const CLI::ParseError& error) {
    return program::EndOfParse(app, error, json);
  } catch (const std::exception& error) {
    program::SayError(error.what());
    return kFailed;
  }
  return exit_code;
}
