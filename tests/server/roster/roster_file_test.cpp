#include "server/roster/roster_file.h"

#include <gtest/gtest.h>

#include "common/base/file.h"

namespace enamel::server::roster {
namespace {

// "row column: found | expected" of everything that is wrong.
std::vector<std::string> Problems(const std::string& text, const RosterOptions& options = {}) {
  std::vector<std::string> out;
  for (const RosterProblem& p : ReadRoster(text, options).problems) {
    out.push_back(std::to_string(p.row) + " " + p.column + ": " + p.found + " | " + p.expected);
  }
  return out;
}

testing::AssertionResult OneProblem(const std::string& text, const std::string& begin,
                                    const std::string& part = "") {
  auto problems = Problems(text);
  if (problems.size() == 1 && problems[0].starts_with(begin) &&
      problems[0].find(part) != std::string::npos) {
    return testing::AssertionSuccess();
  }
  return testing::AssertionFailure() << testing::PrintToString(problems);
}

TEST(RosterFileTest, GoldenRosterReadsAsItsDocumentSays) {
  auto text = ReadFile(ENAMEL_SOURCE_DIR "/schemas/golden/roster.csv");
  ASSERT_TRUE(text.ok());
  RosterFile file = ReadRoster(AsText(*text), {});
  ASSERT_TRUE(file.problems.empty());
  ASSERT_EQ(file.rows.size(), 3u);
  EXPECT_EQ(file.rows[1].login, "b.vega");
  EXPECT_EQ(file.rows[1].display_name, "Vega, Bruno");
  EXPECT_EQ(file.rows[1].row, 3u);
  EXPECT_EQ(file.rows[2].role, Role::kInstructor);
  EXPECT_EQ(file.rows[2].cohort, "Year 3");
}

TEST(RosterFileTest, ColumnsComeInAnyOrderCaseAndSpelling) {
  RosterFile file =
      ReadRoster("\xef\xbb\xbf Cohort ,LOGIN,Display Name\r\nY, Ada ,  Zoë  \r\n", {});
  ASSERT_TRUE(file.problems.empty());
  ASSERT_EQ(file.rows.size(), 1u);
  EXPECT_EQ(file.rows[0].login, "ada");
  EXPECT_EQ(file.rows[0].display_name, "Zoë");
  EXPECT_EQ(file.rows[0].cohort, "Y");
  EXPECT_EQ(file.rows[0].role, Role::kStudent);
}

TEST(RosterFileTest, CohortOfTheCommandIsForRowsWithoutOne) {
  RosterFile file = ReadRoster("login,cohort\na,\nb,Own\n", {"Given", false});
  EXPECT_EQ(file.rows[0].cohort, "Given");
  EXPECT_EQ(file.rows[1].cohort, "Own");
}

TEST(RosterFileTest, EverythingThatIsWrongIsToldAtOnceWithRowAndColumn) {
  auto problems = Problems(
      "login,display_name,role,cohort\n"
      "ok,Fine,,\n"
      "a b,=cmd(),dean,@x\n"
      "c,d\n"
      "root,Root,admin,\n");
  ASSERT_EQ(problems.size(), 6u) << testing::PrintToString(problems);
  EXPECT_TRUE(problems[0].starts_with("3 login: \"a b\" | 1 to 64 letters"));
  EXPECT_TRUE(problems[1].starts_with("3 display_name: \"=cmd()\" | a name that does not begin"));
  EXPECT_TRUE(problems[2].starts_with("3 role: \"dean\" | student or instructor"));
  EXPECT_TRUE(problems[3].starts_with("3 cohort: "));
  EXPECT_TRUE(problems[4].starts_with("4 : 2 cells | 4 as in the first row"));
  EXPECT_TRUE(problems[5].starts_with("5 role: \"admin\" | "));
}

TEST(RosterFileTest, OtherSeparatorsAndEncodingsAreNamedWithTheWayOut) {
  EXPECT_TRUE(OneProblem("login\tdisplay_name\n", "1 : cells separated by tabs", "list separator"));
  EXPECT_TRUE(OneProblem("\xff\xfel\0o\0", "1 : text in UTF-16", "CSV UTF-8"));
  EXPECT_TRUE(
      OneProblem("login,display_name\na,M\xfcller\n", "2 : bytes that are no text", "UTF-8"));
}

TEST(RosterFileTest, MissingTwofoldAndUnknownColumnsAreRefused) {
  EXPECT_TRUE(OneProblem("", "1 : an empty file", "login"));
  EXPECT_TRUE(OneProblem("display_name\nAda\n", "1 login: no such column"));
  EXPECT_TRUE(OneProblem("login,Login\na,b\n", "1 login: the column twice"));
  EXPECT_TRUE(OneProblem("login,rol\na,instructor\n", "1 \"rol\"", "take the column out"));
  RosterFile file = ReadRoster("login, E-Mail \na,a@x.example\n", {"", true});
  EXPECT_TRUE(file.problems.empty());
  EXPECT_EQ(file.ignored_columns, std::vector<std::string>{"E-Mail"});
  EXPECT_EQ(file.rows.size(), 1u);
}

TEST(RosterFileTest, BoundsHold) {
  EXPECT_TRUE(OneProblem(std::string(kMaxRosterBytes + 1, 'a'), "1 : 1048577 bytes"));
  std::string many = "login\n";
  for (size_t i = 0; i <= kMaxRosterRows; ++i) many += "s" + std::to_string(i) + "\n";
  EXPECT_TRUE(OneProblem(many, "5002 : a row number 5002 with text", "5001 rows"));
  EXPECT_TRUE(OneProblem("login,display_name\na,\"b\n", "2 : a quote that is never closed"));
  EXPECT_TRUE(OneProblem("login,display_name\na,\xe2\x80\xae evil\n",
                         "2 display_name: character number 8238"));
}

TEST(RosterFileTest, Latin1IsToldWithItsRowAndHowToSaveIt) {
  for (const std::string text : {"login,role\nok,student\njos\xe9,student\n",
                                 "login,role\r\nok,student\r\nx,\xe9tudiant\r\n"}) {
    EXPECT_TRUE(OneProblem(text, "3 : bytes that are no text in UTF-8", "CSV UTF-8"));
  }
  EXPECT_TRUE(OneProblem("login,r\xf4le\njose,student\n", "1 : bytes that are no text"));
}

}  // namespace
}  // namespace enamel::server::roster
