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

constexpr char kFooter[] = R"(Which question is answered by which command:
  does a force law hold on this device?           enamel-lab qualify --profile omega3 --quick
  ... in numbers and pictures                     enamel-lab qualify --profile omega3 --report omega3.html
  what became of the paper this began with?       enamel-lab paper
  what does more accuracy cost?                   enamel-lab error --quick
  is this computer fast enough for a tick?        enamel-lab bench tick --quick
  ... for a picture                               enamel-lab bench frames --frames 60
  did a change alter how a tooth looks?           enamel-lab pictures --compare tests/golden/pictures
  what of a scene is carried, and within budget?  enamel-lab explain builtin:molar --budget-us 200
  does a grade find what was done wrong?          enamel-lab grades --quick
  what does a grade say of each fault?            enamel-lab reasons --sheet reasons.html
  does a grade tell skill?                        enamel-lab operators --quick
  how hard is a tissue to cut, from a recording?  enamel-lab fit-damping cut.csv --material cut.json
Every command has its own --help. Most write their rows with --json FILE.
Settings: as those of enamel-station (schemas/station_settings.md); keys of its file that are not
the lab's are passed over.
Exit codes: 0 done, 1 failed (the reason is on standard error), 2 wrong command line, or a force law
that is proved passive gave energy.)";

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
  // After the commands, which would inherit it.
  app.footer(kFooter);
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
