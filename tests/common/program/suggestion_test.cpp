#include "common/program/suggestion.h"

#include <gtest/gtest.h>

namespace enamel::program {
namespace {

std::string AfterParsing(std::vector<std::string> words,
                         std::string (*say)(const CLI::App&) = Suggestion) {
  CLI::App app("program");
  app.require_subcommand(0, 1);
  for (const char* name : {"run", "spool", "simulate", "scenes"}) {
    CLI::App* command = app.add_subcommand(name);
    command->add_option("--seed");
    command->add_option("--profile");
  }
  std::ranges::reverse(words);  // as CLI::App::parse takes them
  try {
    app.parse(words);
  } catch (const CLI::ParseError&) {
    return say(app);
  }
  return "no error";
}

TEST(SuggestionTest, NamesTheCommandOrOptionThatIsNearlyTheWord) {
  EXPECT_EQ(AfterParsing({"rnu"}), "did you mean 'run'?");
  EXPECT_EQ(AfterParsing({"simulat"}), "did you mean 'simulate'?");
  EXPECT_EQ(AfterParsing({"run", "--sede", "3"}), "did you mean '--seed'?");
  EXPECT_EQ(AfterParsing({"run", "--profiel=x"}), "did you mean '--profile'?");
}

TEST(SuggestionTest, SaysNothingForAWordThatIsNearNothingOrToTwo) {
  EXPECT_EQ(AfterParsing({"dance"}), "");
  EXPECT_EQ(AfterParsing({"xy"}), "");
  EXPECT_EQ(AfterParsing({"run", "--unknown"}), "");
}

TEST(SuggestionTest, AWordThatIsNoCommandIsNamed) {
  EXPECT_EQ(AfterParsing({"dance"}, UnknownCommand), "dance");
  EXPECT_EQ(AfterParsing({"rnu", "--seed", "3"}, UnknownCommand), "rnu");
  // Below a command that has none of its own, a word too many is no command.
  EXPECT_EQ(AfterParsing({"run", "dance"}, UnknownCommand), "");
  EXPECT_EQ(AfterParsing({"run", "--unknown"}, UnknownCommand), "");
  EXPECT_EQ(AfterParsing({"--unknown", "value"}, UnknownCommand), "");
}

}  // namespace
}  // namespace enamel::program
