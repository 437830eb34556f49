#include "server/commands/command_line.h"
#include "server/commands/commands.h"
#include "tests/support/every_command.h"

namespace enamel::server::app {
namespace {

TEST(HelpTest, EveryCommandHasAnExampleThatItTakesAndDescribesItsOptions) {
  CLI::App root("", "enamel-server");
  std::function<Status()> chosen;
  DeclareCommands({root, chosen});
  test::ExpectHelpOfEveryCommand(root);
}

TEST(HelpTest, AGuideNamesEveryOption) {
  CLI::App root("", "enamel-server");
  std::function<Status()> chosen;
  DeclareCommands({root, chosen});
  test::ExpectEveryOptionIsNamed(root, test::AllMarkdown(ENAMEL_SOURCE_DIR));
}

}  // namespace
}  // namespace enamel::server::app
