#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "common/program/command_settings.h"
#include "common/program/log.h"
#include "common/program/suggestion.h"
#include "common/program/version.h"
#include "station/lab/app/cli.h"

namespace {

using namespace enamel;

// Uses the station's settings, so that a machine's measurements have one place for them.
constexpr char kName[] = "enamel-lab", kPrefix[] = "ENAMEL_STATION_";
constexpr int kFailed = 1;

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("enamel-lab: measures force laws, cutting and this computer.", kName);
  app.require_subcommand(1);
  app.set_version_flag("--version", program::VersionText(kName));
  // Before parsing, so that a wrong command line is refused in the requested format.
  const bool json = program::AsksForJson(argc, argv, kPrefix);
  (void)program::SetUpLog({.format = json ? "json" : "text", .name = kName});
  // A long measurement's rows appear as they come, in a file too.
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  int exit_code = 0;
  station::lab::RegisterLab(app, &exit_code);
  program::CommandSettings settings(app, {.program = kName,
                                          .prefix = kPrefix,
                                          .system_file = "/etc/enamel/station.toml",
                                          // The file is the station's; keys of its own commands are
                                          // no mistakes here.
                                          .shared = true});
  settings.Add();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program::EndOfParse(app, error, json);
    // Of a suite, such as no memory for its rows.
  } catch (const std::exception& error) {
    program::SayError(error.what());
    return kFailed;
  }
  return exit_code;
}
