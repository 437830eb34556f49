#include "station/lab/app/cli.h"
#include "tests/support/every_command.h"

namespace enamel::station::lab {
namespace {

TEST(HelpTest, EveryCommandHasAnExampleThatItTakesAndDescribesItsOptions) {
  CLI::App app("", "enamel-lab");
  int exit_code = 0;
  RegisterLab(app, &exit_code);
  test::ExpectHelpOfEveryCommand(app);
}

TEST(HelpTest, AGuideNamesEveryOption) {
  CLI::App app("", "enamel-lab");
  int exit_code = 0;
  RegisterLab(app, &exit_code);
  test::ExpectEveryOptionIsNamed(app, test::AllMarkdown(ENAMEL_SOURCE_DIR));
}

}  // namespace
}  // namespace enamel::station::lab
