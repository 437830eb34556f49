#include "common/program/settings.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/base/uuid.h"

// Command line before environment before file.
namespace enamel::program {
namespace {

class SettingsTest : public ::testing::Test {
 protected:
  SettingsTest() {
    command_.add_option("--data", data_, "Where data is");
    command_.add_option("--threads", threads_, "How many")
        ->check(CLI::Range(1, 8))
        ->capture_default_str();
    command_.add_option("--host-name", names_, "Names (repeatable)");
    command_.add_flag("--quiet", quiet_, "Say less");
    command_.add_option("--config", config_);
  }
  ~SettingsTest() override {
    ::unsetenv("ENAMEL_THREADS");
    std::filesystem::remove(file_);
  }
  Status Read(const std::string& toml, std::vector<std::string> arguments = {}) {
    std::ofstream(file_) << toml;
    std::reverse(arguments.begin(), arguments.end());  // CLI11 takes them from the back
    command_.parse(arguments);
    ENAMEL_RETURN_IF_ERROR(ReadEnvironment(command_));
    return ReadSettingsFile(file_, command_);
  }

  CLI::App command_;
  std::string data_, config_;
  int threads_ = 2;
  std::vector<std::string> names_;
  bool quiet_ = false;
  const std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / ("enamel-test-" + Uuid::New().Text() + ".toml");
};

TEST_F(SettingsTest, FileGivesWhatNobodyElseGave) {
  Status read = Read(
      "data = '/srv/enamel' # a comment\nthreads = 3\nhost_name = ['a.example', 'b.example']\n"
      "quiet = true\n");
  ASSERT_TRUE(read.ok()) << read.message();
  EXPECT_EQ(data_, "/srv/enamel");
  EXPECT_EQ(threads_, 3);
  EXPECT_EQ(names_, (std::vector<std::string>{"a.example", "b.example"}));
  EXPECT_TRUE(quiet_);
}

TEST_F(SettingsTest, EnvironmentIsNearerThanTheFile) {
  ::setenv("ENAMEL_THREADS", "4", 1);
  ASSERT_TRUE(Read("threads = 3\n").ok());
  EXPECT_EQ(threads_, 4);
}

TEST_F(SettingsTest, EnvironmentThatTheOptionRefusesIsNamed) {
  ::setenv("ENAMEL_THREADS", "many", 1);
  Status refused = Read("");
  EXPECT_EQ(refused.code(), Code::kInvalidInput);
  EXPECT_NE(refused.message().find("ENAMEL_THREADS"), std::string::npos) << refused.message();
}

TEST_F(SettingsTest, CommandLineIsNearest) {
  ::setenv("ENAMEL_THREADS", "4", 1);
  ASSERT_TRUE(Read("threads = 3\n", {"--threads", "5"}).ok());
  EXPECT_EQ(threads_, 5);
}

TEST_F(SettingsTest, UnknownKeyIsRefusedWithItsPlaceAndTheKnownOnes) {
  Status refused = Read("data = 'x'\nthread = 3\n");
  EXPECT_EQ(refused.code(), Code::kInvalidInput);
  EXPECT_NE(refused.message().find(":2:1"), std::string::npos) << refused.message();
  EXPECT_NE(refused.message().find("threads"), std::string::npos);
  EXPECT_FALSE(Read("config = 'x'\n").ok()) << "a file does not name another file";
}

TEST_F(SettingsTest, UnknownKeyIsAnsweredAlikeWhicheverCommandReadsTheFile) {
  CLI::App program;
  std::string place;
  program.add_subcommand("run")->add_option("--keep-days", place);
  CLI::App* group = program.add_subcommand("spool");
  group->add_subcommand("list")->add_option("--data", place);
  const std::set<std::string> all = SettingNames(program);
  std::set<std::string> answers;
  for (CLI::App* command : {program.get_subcommand("run"), group, group->get_subcommand("list")}) {
    answers.insert(ReadSettings("keep-dayz = 3\n", "station.toml", *command, all).message());
  }
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(*answers.begin(),
            "station.toml:1:1: expected one of data, keep-days; found \"keep-dayz\"");
}

TEST_F(SettingsTest, OfManySettingsThoseLikeTheUnknownOneAreNamed) {
  CLI::App program;
  std::vector<std::string> values(40);
  for (size_t i = 1; i < values.size(); ++i) {
    program.add_option("--" + std::string(i, 'x'), values[i]);
  }
  program.add_option("--keep-days", values[0]);
  EXPECT_EQ(ReadSettings("kepe_days = 3\n", "station.toml", program).message(),
            "station.toml:1:1: expected one of keep-days, x, xx, xxx, xxxx (the nearest of 40 "
            "settings); found \"kepe_days\"");
}

TEST_F(SettingsTest, ValueThatTheOptionRefusesIsRefused) {
  for (const char* toml : {"threads = 9\n", "threads = 'many'\n", "threads = 1.5\n",
                           "threads = [1, 2]\n", "[data]\nx = 1\n", "data = 1979-05-27\n"}) {
    Status refused = Read(toml);
    EXPECT_EQ(refused.code(), Code::kInvalidInput) << toml;
    EXPECT_NE(refused.message().find(file_.string() + ":"), std::string::npos) << refused.message();
  }
}

TEST_F(SettingsTest, WhatIsNoTomlIsRefusedWithItsPlace) {
  for (const char* toml : {"data = \n", "= 3\n", "data = 'a\n", "threads = 3\nthreads = 4\n"}) {
    Status refused = Read(toml);
    EXPECT_EQ(refused.code(), Code::kInvalidInput) << toml;
    EXPECT_NE(refused.message().find(file_.string() + ":"), std::string::npos);
  }
}

TEST_F(SettingsTest, PrintedSettingsReadBackTheSame) {
  ASSERT_TRUE(Read("data = 'a \"b\" \\ c'\nhost-name = ['x', 'y']\n", {"--threads", "7"}).ok());
  std::string printed = SettingsText(command_);
  EXPECT_NE(printed.find("# Where data is"), std::string::npos);
  CLI::App other;
  std::string data;
  int threads = 0;
  std::vector<std::string> names;
  bool quiet = true;
  other.add_option("--data", data);
  other.add_option("--threads", threads);
  other.add_option("--host-name", names);
  other.add_flag("--quiet", quiet);
  std::ofstream(file_) << printed;
  Status read = ReadSettingsFile(file_, other);
  ASSERT_TRUE(read.ok()) << read.message() << "\n" << printed;
  EXPECT_EQ(data, data_);
  EXPECT_EQ(threads, 7);
  EXPECT_EQ(names, names_);
}

TEST_F(SettingsTest, OptionsOfAGroupStandInItsSection) {
  int views = 5, links = 6;
  command_.add_option("--budgets-views", views, "Views")
      ->check(CLI::Range(1, 100))
      ->group("budgets")
      ->capture_default_str();
  command_.add_option("--budgets-links", links, "Links")->group("budgets")->capture_default_str();
  ASSERT_TRUE(Read("threads = 3\n[budgets]\nviews = 40\n").ok());
  EXPECT_EQ(threads_, 3);
  EXPECT_EQ(views, 40);
  EXPECT_EQ(links, 6);
  EXPECT_TRUE(SettingsIn(file_).contains("budgets-views"));
  const std::string printed = SettingsText(command_);
  EXPECT_NE(printed.find("\n[budgets]\n# Views\nviews = '40'\n# Links\nlinks = '6'\n"),
            std::string::npos)
      << printed;
}

TEST_F(SettingsTest, KeysOfSectionsAreRefusedAsThoseOfTheFileAre) {
  int views = 5;
  command_.add_option("--budgets-views", views)->check(CLI::Range(1, 100))->group("budgets");
  struct {
    const char* file;
    const char* says;
  } const cases[] = {
      {"[budgets]\nview = 40\n", "found \"view\""},
      {"[budgets]\nviews = 400\n", ":2:9: budgets-views: "},
      {"budgets-views = 40\n", "found \"budgets-views\""},
      {"[budget]\nviews = 40\n", "found \"budget\""},
  };
  for (const auto& [file, says] : cases) {
    const Status read = Read(file);
    EXPECT_EQ(read.code(), Code::kInvalidInput) << file;
    EXPECT_NE(read.message().find(says), std::string::npos) << read.message();
  }
  EXPECT_EQ(views, 5);
}

TEST_F(SettingsTest, FileOfAnotherProgramTooKeepsItsKeysButMustBeRight) {
  std::ofstream(file_) << "threads = 3\nkeep-days = 30\n";
  EXPECT_EQ(ReadSettingsFile(file_, command_).code(), Code::kInvalidInput);
  EXPECT_TRUE(ReadSettingsFile(file_, command_, {kAnyKey}).ok());
  EXPECT_EQ(threads_, 3);
  std::ofstream(file_) << "quiet = 'maybe'\nkeep-days = 30\n";
  EXPECT_EQ(ReadSettingsFile(file_, command_, {kAnyKey}).code(), Code::kInvalidInput);
}

TEST_F(SettingsTest, PolicyIsBehindTheFileUnlessItIsFixedAndNeverBeforeTheCommandLine) {
  const auto after = [&](const std::string& toml, std::vector<std::string> arguments, bool fixed) {
    command_.clear();
    threads_ = 2;
    ::unsetenv("ENAMEL_THREADS");
    std::ofstream(file_) << toml;
    command_.parse(arguments);
    const std::set<std::string> nearer = GivenSettings(command_);
    EXPECT_TRUE(ReadSettingsFile(file_, command_).ok());
    EXPECT_TRUE(ApplyPolicy({{"threads", "6", fixed}}, command_, nearer).empty());
    return threads_;
  };
  EXPECT_EQ(after("", {}, false), 6);
  EXPECT_EQ(after("threads = 3\n", {}, false), 3);
  EXPECT_EQ(after("threads = 3\n", {}, true), 6);
  EXPECT_EQ(after("threads = 3\n", {"5", "--threads"}, true), 5);
}

TEST_F(SettingsTest, WrongValueOfAPolicyIsSaidAndTheFilesStays) {
  ASSERT_TRUE(Read("threads = 3\n").ok());
  const auto wrong = ApplyPolicy({{"threads", "9", true},
                                  {"moon", "1", true},
                                  {"config", "x", true},
                                  {"quiet", "true", false}},
                                 command_, {});
  ASSERT_EQ(wrong.size(), 1u);
  EXPECT_NE(wrong[0].find("threads"), std::string::npos) << wrong[0];
  EXPECT_EQ(threads_, 3);
  EXPECT_EQ(command_.count("--threads"), 1u);
  EXPECT_EQ(config_, "") << "no place for settings is itself one";
  EXPECT_TRUE(quiet_);
}

TEST_F(SettingsTest, SettingsOfAFileAreNamedAsItsOptionsAre) {
  std::ofstream(file_) << "keep_days = 30\nlanguage = 'de'\n";
  EXPECT_EQ(SettingsIn(file_), (std::set<std::string>{"keep-days", "language"}));
  std::ofstream(file_) << "keep_days = = 30\n";
  EXPECT_TRUE(SettingsIn(file_).empty());
  EXPECT_TRUE(SettingsIn("/nowhere").empty());
}

}  // namespace
}  // namespace enamel::program
