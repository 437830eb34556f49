#include "common/program/example.h"

#include <gtest/gtest-spi.h>

#include "tests/support/every_command.h"

namespace enamel::program {
namespace {

// A program with one command in a group, and an option of it.
struct Program {
  CLI::App app{"", "enamel-server"};
  CLI::App* group = app.add_subcommand("school");
  CLI::App* add = group->add_subcommand("add");
  std::string host;
  Program() {
    add->add_option("--host", host, "Its name")->required();
    for (CLI::App* each : {&app, group})
      AddExamples(*each, {each == group ? "add --host a" : "school add --host a"});
  }
};

TEST(ExampleTest, ExamplesStandAtTheEndOfTheHelpWithTheCommandsWords) {
  Program p;
  p.add->footer("It takes a minute.");
  AddExamples(*p.add, {"--host a", "--host b  # another"});
  EXPECT_EQ(p.add->get_footer(),
            "It takes a minute.\n\nExamples:\n  enamel-server school add --host a\n"
            "  enamel-server school add --host b  # another");
  test::ExpectHelpOfEveryCommand(p.app);
}

TEST(ExampleTest, AHelpThatShowsNoCommandLineIsFound) {
  Program none, wrong, quiet;
  EXPECT_NONFATAL_FAILURE(test::ExpectHelpOfEveryCommand(none.app), "school add --help has no");
  AddExamples(*wrong.add, {"--host a", "--hots b"});
  EXPECT_NONFATAL_FAILURE(test::ExpectHelpOfEveryCommand(wrong.app), "--hots");
  AddExamples(*quiet.add, {"--host a"});
  quiet.add->add_flag("--again");
  EXPECT_NONFATAL_FAILURE(test::ExpectHelpOfEveryCommand(quiet.app), "--again has no description");
}

TEST(ExampleTest, AnOptionThatNoMarkdownNamesIsFound) {
  Program p;
  for (const char* names : {"`--host a`", "a sentence.\nhost = \"a\"\n", "| `host` | text |"}) {
    test::ExpectEveryOptionIsNamed(p.app, std::string(names) + " --help");
  }
  for (const char* other : {"--hosts", "--host-name", "---host", "host", "the host = a"}) {
    EXPECT_NONFATAL_FAILURE(test::ExpectEveryOptionIsNamed(p.app, std::string(other) + " --help"),
                            "school add --host: no Markdown names it");
  }
}

}  // namespace
}  // namespace enamel::program
