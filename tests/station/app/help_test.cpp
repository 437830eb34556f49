#include "station/app/command_line.h"
#include "tests/support/every_command.h"

namespace enamel::station {
namespace {

TEST(HelpTest, EveryCommandHasAnExampleThatItTakesAndDescribesItsOptions) {
  CLI::App app("", "enamel-station");
  WorkplaceSettings place;
  const program::CommandSettings settings(app, {});
  int exit_code = 0;
  DeclareCommands({app, place, settings, exit_code});
  test::ExpectHelpOfEveryCommand(app);
}

TEST(HelpTest, AGuideNamesEveryOption) {
  CLI::App app("", "enamel-station");
  WorkplaceSettings place;
  const program::CommandSettings settings(app, {});
  int exit_code = 0;
  DeclareCommands({app, place, settings, exit_code});
  test::ExpectEveryOptionIsNamed(app, test::AllMarkdown(ENAMEL_SOURCE_DIR));
}

}  // namespace
}  // namespace enamel::station
