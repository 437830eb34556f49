#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/program/log.h"
#include "common/program/suggestion.h"
#include "common/program/version.h"
#include "station/app/command_line.h"
#include "station/uplink/policy_file.h"

// enamel-station: its commands.
namespace {

using namespace enamel;
using namespace enamel::station;

constexpr char kName[] = "enamel-station", kPrefix[] = "ENAMEL_STATION_";
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
  CLI::App app("enamel-station: cut virtual teeth; every tick is recorded and sent to the server.",
               kName);
  app.require_subcommand(0, 1);
  app.set_version_flag("--version", program::VersionText(kName));
  int exit_code = 0;
  program::CommandSettings settings(app, {.program = kName,
                                          .prefix = kPrefix,
                                          .system_file = "/etc/enamel/station.toml",
                                          .policy = PolicyIn});
  WorkplaceSettings place;
  place.data = DefaultData();
  const OpenCommand open = DeclareCommands({app, place, settings, exit_code});
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
