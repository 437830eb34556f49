#include "server/commands/commands.h"

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

namespace enamel::server::app {

// Each command declares itself and its action; nothing runs until the whole line has been parsed.
void DeclareCommands(CommandGroup root) {
  for (auto declare :
       {DeclareServe, DeclareWork, DeclareInit, DeclareDoctor, DeclareSupportBundle, DeclareBackup,
        DeclareVerifyResult, DeclareMove, DeclareRetention, DeclareSchools, DeclareSeed,
        DeclareReport, DeclareRescore, DeclareAgreement, DeclareStandard}) {
    declare(root);
  }
  auto* admin = root.parent.add_subcommand(
      "admin", "Manage people, cohorts, stations, exercises, references");
  admin->require_subcommand(1);
  for (auto declare :
       {DeclarePeople, DeclareRoster, DeclareSessions, DeclareStations, DeclareStationSettings,
        DeclareProfiles, DeclarePersonalData, DeclareAttempts, DeclareExercises, DeclareTargets,
        DeclareRubrics, DeclareAssignments}) {
    declare({*admin, root.chosen});
  }
  AddExample(admin, "list-people");
  root.parent.footer(
      "First steps:\n"
      "  enamel-server serve --data /var/lib/enamel            # in one terminal; then, in "
      "another:\n"
      "  enamel-server admin add-person --data /var/lib/enamel --login anna --role admin\n"
      "  enamel-server admin enrol-code --data /var/lib/enamel # for `enamel-station enrol`\n"
      "Each command has its own --help. Exit codes: 0 done, 1 refused or failed, 2 wrong usage.");
}

}  // namespace enamel::server::app
