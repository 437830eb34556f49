#include <sodium.h>

#include <CLI/CLI.hpp>
#include <functional>

#include "common/base/utf8.h"
#include "common/program/log.h"
#include "common/program/private_memory.h"
#include "common/program/suggestion.h"
#include "common/program/version.h"
#include "server/commands/admin.h"
#include "server/commands/admin_people.h"
#include "server/commands/admin_stations.h"
#include "server/commands/agreement.h"
#include "server/commands/command_line.h"
#include "server/commands/init.h"
#include "server/commands/move.h"
#include "server/commands/personal_data.h"
#include "server/commands/prepared.h"
#include "server/commands/regrade.h"
#include "server/commands/report.h"
#include "server/commands/school_commands.h"
#include "server/commands/serving.h"
#include "server/commands/standard.h"
#include "server/commands/teaching.h"
#include "server/commands/upkeep.h"
#include "server/commands/verify_result.h"

// enamel-server: which commands there are. Exit codes: 0 done, 1 refused or failed, 2 wrong usage.
using namespace enamel;
using namespace enamel::server;

int main(int argc, char** argv) {
  program::KeepMemoryPrivate();
  // Found out before the command line is parsed, so that a refusal of the command line itself is
  // already said in the format that the log's reader expects.
  const bool json = program::AsksForJson(argc, argv, "ENAMEL_");
  (void)program::SetUpLog({.format = json ? "json" : "text"});
  if (sodium_init() < 0) {
    program::SayError("libsodium cannot be initialised on this machine");
    return 1;
  }
  CLI::App root("Enamel server: station link, storage, scoring, API and page");
  root.require_subcommand(1);
  root.set_version_flag("--version", program::VersionText("enamel-server"));
  std::function<Status()> command;
  const app::CommandGroup top{root, command};
  // Each command declares itself and its action; nothing runs until the whole line has been parsed.
  app::DeclareServe(top);
  app::DeclareWork(top);
  app::DeclareInit(top);
  app::DeclareDoctor(top);
  app::DeclareSupportBundle(top);
  app::DeclareBackup(top);
  app::DeclareVerifyResult(top);
  app::DeclareMove(top);
  app::DeclareRetention(top);
  app::DeclareSchools(top);
  app::DeclareSeed(top);
  app::DeclareReport(top);
  app::DeclareRescore(top);
  app::DeclareAgreement(top);
  app::DeclareStandard(top);
  auto* admin =
      root.add_subcommand("admin", "Manage people, cohorts, stations, exercises, references");
  admin->require_subcommand(1);
  for (auto declare : {app::DeclarePeople, app::DeclareRoster, app::DeclareSessions,
                       app::DeclareStations, app::DeclareStationSettings, app::DeclareProfiles,
                       app::DeclarePersonalData, app::DeclareAttempts, app::DeclareExercises,
                       app::DeclareTargets, app::DeclareRubrics, app::DeclareAssignments}) {
    declare({*admin, command});
  }
  root.footer(
      "First steps:\n"
      "  enamel-server serve --data DIR                 in one terminal; then, in another:\n"
      "  enamel-server admin add-person --data DIR --login anna --role admin\n"
      "  enamel-server admin enrol-code --data DIR      for `enamel-station enrol`\n"
      "Each command has its own --help. Exit codes: 0 done, 1 refused or failed, 2 wrong usage.");
  try {
    root.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program::EndOfParse(root, error, json);
  }
  Status status = command();
  if (status.ok()) return 0;
  program::SayError(std::string(Printable(status.message())));
  return 1;
}
