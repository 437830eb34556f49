#include "server/roster/roster_file.h"

#include <gtest/gtest.h>

#include <filesystem>

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

TEST(RosterFileTest, SeparatorsOfSpreadsheetsAreRead) {
  for (const std::string separator : {",", ";", "\t", "|"}) {
    const std::string table = "login" + separator + "cohort\nada" + separator + "Year 3\n";
    for (const std::string& text : {table, "sep=" + separator + "\r\n" + table}) {
      const RosterFile file = ReadRoster(text, {});
      ASSERT_TRUE(file.problems.empty()) << text << file.problems[0].found;
      EXPECT_EQ(file.rows.at(0).cohort, "Year 3") << text;
    }
  }
}

// "login,cohort" and a row of Müller's in Übung, in each encoding.
TEST(RosterFileTest, BytesAreReadInTheEncodingThatTheyHave) {
  const std::string utf8 = "login,display_name,cohort\nm,Müller,Übung\n";
  const std::string latin =
      "login,display_name,cohort\nm,M\xfcller,\xdc"
      "bung\n";
  std::string little, big;
  for (char c : latin) {
    little += std::string{c, '\0'};
    big += std::string{'\0', c};
  }
  const std::pair<std::string, const char*> kFiles[] = {
      {utf8, "utf-8"},        {"\xef\xbb\xbf" + utf8, "utf-8"},
      {little, "utf-16le"},   {"\xff\xfe" + little, "utf-16le"},
      {big, "utf-16be"},      {"\xfe\xff" + big, "utf-16be"},
      {latin, "windows-1252"}};
  for (const auto& [bytes, reading] : kFiles) {
    const RosterFile file = ReadRoster(bytes, {});
    EXPECT_EQ(file.reading, reading);
    ASSERT_TRUE(file.problems.empty()) << reading << ": " << file.problems[0].found;
    ASSERT_EQ(file.rows.size(), 1u) << reading;
    EXPECT_EQ(file.rows[0].display_name, "Müller") << reading;
    EXPECT_EQ(file.rows[0].cohort, "Übung") << reading;
  }
}

TEST(RosterFileTest, AnotherReadingIsTakenWhereOneIsNamed) {
  const auto name = [](const std::string& bytes, const std::string& reading) {
    const RosterFile file =
        ReadRoster("login,display_name\na," + bytes + "\n", {"", false, reading});
    EXPECT_EQ(file.reading, reading);
    return file.rows.empty() ? file.problems.at(0).found : file.rows[0].display_name;
  };
  EXPECT_EQ(name("\xd1\xeb\xe0\xe2\xe0", "windows-1251"), "Слава");
  EXPECT_EQ(name("\xa3ukasz", "windows-1250"), "Łukasz");
  EXPECT_EQ(name("\xc0\xee\xc3\xf7", "gb18030"), "李明");
  EXPECT_EQ(name("Zo\xeb", "utf-8"), "bytes that are no text in utf-8");
  // An earlier program could not read the name.
  EXPECT_TRUE(OneProblem("login,display_name\nok,Ok\nz,Zo\xef\xbf\xbd\n",
                         "3 : bytes that are no text in utf-8", "another reading"));
}

TEST(RosterFileTest, TextsThatLookTheSameAreTheSame) {
  const RosterFile file = ReadRoster(
      "login,display_name,role,cohort\n"
      "a,Ana,student,\xc3\x9c"
      "bung A\n"
      "b\xc2\xa0,Bo,student\xc2\xa0,U\xcc\x88"
      "bung\xc2\xa0"
      "A\n",
      {});
  ASSERT_TRUE(file.problems.empty()) << file.problems[0].found;
  ASSERT_EQ(file.rows.size(), 2u);
  EXPECT_EQ(file.rows[0].cohort, file.rows[1].cohort);
  EXPECT_EQ(file.rows[1].login, "b");
}

TEST(RosterFileTest, EmptyColumnsAndATotalBelowTheListAreNoProblem) {
  const RosterFile file = ReadRoster(
      "login,,display_name,cohort,,\na,,Ana,Kurs 1,,\nb,,Bo,Kurs 1\n,,,,,\nTotal: 2,,,,,\n", {});
  ASSERT_TRUE(file.problems.empty()) << file.problems[0].found;
  EXPECT_EQ(file.rows.size(), 2u);
  ASSERT_EQ(file.left_out.size(), 1u);
  EXPECT_EQ(file.left_out[0].row, 5u);
  EXPECT_EQ(file.left_out[0].text, "Total: 2");
  EXPECT_TRUE(OneProblem("login,cohort,,\na,Year,3,\n", "2 : \"3\" in a column without a name",
                         "comma inside a name"));
  EXPECT_TRUE(OneProblem("login,cohort\na b,\nc,Year 3\n", "2 login: \"a b\""))
      << "somebody comes below";
  EXPECT_TRUE(OneProblem("login\na\nb c\n", "3 login: \"b c\""));
}

TEST(RosterFileTest, ARefusalKeepsTheWholeTextThatItFound) {
  EXPECT_TRUE(OneProblem("login,display_name\na,\"=lost, found again\"\n",
                         "2 display_name: \"=lost, found again\" | a name that does not begin"));
}

// Other programs made these files. Their README says what is right.
TEST(RosterFileTest, ReadsRostersOfOtherPrograms) {
  const std::filesystem::path folder =
      std::filesystem::path(ENAMEL_SHARED_DATA) / "borders/rosters";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "skipped: no shared data";
  const std::pair<const char*, size_t> kPeople[] = {
      {"r01_sep_line.csv", 1}, {"r05_windows1252.csv", 1}, {"r06_nfc_nfd_cohort.csv", 2},
      {"r08_joiners.csv", 3},  {"r10_trailing.csv", 1},    {"names_for_the_chair.csv", 6}};
  for (const auto& [name, people] : kPeople) {
    const auto bytes = ReadFile(folder / name);
    ASSERT_TRUE(bytes.ok()) << name;
    const RosterFile file = ReadRoster(AsText(*bytes), {});
    EXPECT_TRUE(file.problems.empty()) << name << ": " << file.problems[0].found;
    EXPECT_EQ(file.rows.size(), people) << name;
  }
  // Excel's "Unicode text"; a semicolon is no part of a login.
  const RosterFile text = ReadRoster(AsText(*ReadFile(folder / "r04_unicode_text.txt")), {});
  EXPECT_EQ(text.reading, "utf-16le");
  ASSERT_EQ(text.problems.size(), 1u);
  EXPECT_EQ(text.problems[0].column, "login");
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

}  // namespace
}  // namespace enamel::server::roster
