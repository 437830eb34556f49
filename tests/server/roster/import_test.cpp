#include "server/roster/import.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>

#include "common/base/csv.h"
#include "server/auth/password.h"
#include "tests/server/storage/store_world.h"

namespace enamel::server::roster {
namespace {

using namespace server::testing;

const std::string kRoster =
    "login,display_name,role,cohort\n"
    "ada,Ada,instructor,Year 3\n"
    "bob,Bob,,Year 3\n";

class ImportTest : public ::testing::Test {
 protected:
  ImportResult Import(const std::string& csv, bool dry_run = false) {
    ImportOptions options;
    options.dry_run = dry_run;
    auto result = ImportRoster(store_->roster, csv, options, kSystem);
    EXPECT_TRUE(result.ok()) << result.status().message();
    return std::move(result).value();
  }
  void ExpectAllSignIn(const std::vector<NewPassword>& passwords) {
    for (const NewPassword& made : passwords) {
      const Uuid id = store_->people.PersonByLogin(made.login)->id;
      EXPECT_TRUE(auth::VerifyPassword(made.password, *store_->people.PasswordVerifier(id)))
          << made.login;
    }
  }

  TempFolder folder_;
  std::unique_ptr<Store> store_ = OpenStore(folder_.path());
};

TEST_F(ImportTest, EverybodyNewGetsAPasswordThatWorksAndIsDifferent) {
  ImportResult result = Import(kRoster);
  EXPECT_TRUE(result.done);
  ASSERT_EQ(result.passwords.size(), 2u);
  EXPECT_NE(result.passwords[0].password, result.passwords[1].password);
  ExpectAllSignIn(result.passwords);
  for (const NewPassword& made : result.passwords) EXPECT_EQ(made.password.size(), 19u);
  CsvTable table = ReadCsv(PasswordsCsv(result.passwords));
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.rows[2].cells[0], "bob");
  EXPECT_EQ(table.rows[2].cells[3], result.passwords[1].password);
}

TEST_F(ImportTest, NobodyIsAddedWhosePasswordCannotBeKept) {
  ImportOptions options;
  std::vector<NewPassword> given;
  options.keep = [&](const std::vector<NewPassword>& passwords) {
    given = passwords;
    EXPECT_TRUE(store_->people.People()->empty()) << "before anybody is added";
    return Status(Code::kStorage, "the disk is full");
  };
  EXPECT_EQ(ImportRoster(store_->roster, kRoster, options, kSystem).status().code(),
            Code::kStorage);
  EXPECT_EQ(given.size(), 2u);
  EXPECT_TRUE(store_->people.People()->empty());
  options.keep = [&](const std::vector<NewPassword>& passwords) {
    given = passwords;
    return Status::Ok();
  };
  const auto done = ImportRoster(store_->roster, kRoster, options, kSystem);
  ASSERT_TRUE(done.ok()) << done.status().message();
  EXPECT_EQ(PasswordsCsv(done->passwords), PasswordsCsv(given));
}

TEST_F(ImportTest, DryRunTellsTheSameAndMakesNeitherPeopleNorPasswords) {
  ImportResult result = Import(kRoster, true);
  EXPECT_FALSE(result.done);
  EXPECT_TRUE(result.passwords.empty());
  EXPECT_EQ(result.plan.Count(RosterStep::Change::kCreate), 2u);
  EXPECT_TRUE(store_->people.People()->empty());
}

TEST_F(ImportTest, SomebodyInTwoCohortsHasARowForEach) {
  const std::string rows =
      "login,display_name,role,cohort\nada,Ada,instructor,Year 3\nada,,instructor,Year 4\n"
      "bob,Bob,,Year 3\n";
  ImportResult result = Import(rows);
  ASSERT_TRUE(result.done);
  EXPECT_EQ(result.plan.Count(RosterStep::Change::kCreate), 2u);
  EXPECT_EQ(result.passwords.size(), 2u) << "one password for one person";
  ExpectAllSignIn(result.passwords);
  const Uuid ada = store_->people.PersonByLogin("ada")->id;
  const auto cohorts = store_->cohorts.Cohorts();
  ASSERT_EQ(cohorts->size(), 2u);
  for (const Cohort& cohort : *cohorts) {
    const auto members = *store_->cohorts.CohortMembers(cohort.id);
    EXPECT_TRUE(std::ranges::any_of(members, [&](const Person& each) { return each.id == ada; }))
        << cohort.name;
  }
  EXPECT_EQ(store_->people.PersonByLogin("ada")->display_name, "Ada");
  EXPECT_EQ(Import(rows).plan.Count(RosterStep::Change::kUnchanged), 2u)
      << "again changes nothing, and people are counted";
}

TEST_F(ImportTest, AStudentOfAnotherSectionIsAskedAboutAndMoved) {
  const std::string now = "login,role,cohort\nbob,,Section 2\nada,instructor,Section 2\n";
  ASSERT_TRUE(Import("login,role,cohort\nbob,,Section 1\nada,instructor,Section 1\n"
                     "bob,,Elective\nzoe,,Section 1\n")
                  .done);
  const ImportResult tried = Import(now, true);
  EXPECT_EQ(tried.plan.steps[0].others, (std::vector<std::string>{"Elective", "Section 1"}));
  EXPECT_TRUE(tried.plan.steps[1].others.empty()) << "an instructor has several";
  const auto cohorts_of = [&](const char* login) {
    std::vector<std::string> out;
    const Uuid person = store_->people.PersonByLogin(login)->id;
    const auto cohorts = store_->cohorts.CohortsOf(person);
    for (const Cohort& cohort : *cohorts) out.push_back(cohort.name);
    std::ranges::sort(out);
    return out;
  };
  ImportOptions options;
  options.move = true;
  const std::string both = now + "bob,,Elective\n";
  ASSERT_TRUE(ImportRoster(store_->roster, both, options, kSystem)->done);
  EXPECT_EQ(cohorts_of("bob"), (std::vector<std::string>{"Elective", "Section 2"}));
  EXPECT_EQ(cohorts_of("ada"), (std::vector<std::string>{"Section 1", "Section 2"}));
  EXPECT_EQ(cohorts_of("zoe"), std::vector<std::string>{"Section 1"});
  EXPECT_TRUE(Import(both, true).plan.steps[0].others.empty()) << "nothing to ask";
}

TEST_F(ImportTest, TheOutcomeShowsEveryPersonAsTheyWillBe) {
  ASSERT_TRUE(Import(kRoster).done);
  const auto outcome = ImportJson(Import("login,cohort\nbob,Year 4\nkim,\n", true));
  EXPECT_EQ(outcome.at("reading"), "utf-8");
  const auto& bob = outcome.at("people").at(0);
  EXPECT_EQ(bob.at("display_name"), "Bob");
  EXPECT_EQ(bob.at("role"), "student");
  EXPECT_EQ(bob.at("cohort"), "Year 4");
  EXPECT_EQ(bob.at("others").at(0), "Year 3");
  EXPECT_EQ(outcome.at("people").at(1).at("display_name"), "kim");
}

TEST_F(ImportTest, RowsOfOnePersonMustAgree) {
  ImportResult result = Import(
      "login,display_name,role,cohort\nada,Ada,instructor,Year 3\nada,Ada,student,Year 4\n"
      "ada,Eve,instructor,Year 5\nada,Ada,instructor,Year 3\nada,Ada,instructor,\n");
  ASSERT_EQ(result.plan.problems.size(), 4u);
  EXPECT_EQ(result.plan.problems[0].column, "role");
  EXPECT_EQ(result.plan.problems[0].expected, "instructor as in row 2");
  EXPECT_EQ(result.plan.problems[1].column, "display_name");
  EXPECT_EQ(result.plan.problems[2].expected, "each person once in each cohort");
  EXPECT_EQ(result.plan.problems[3].column, "login");
  EXPECT_FALSE(store_->people.PersonByLogin("ada").ok());
}

TEST_F(ImportTest, ProblemsOfTheFileAndOfWhatIsThereComeTogetherByRow) {
  ASSERT_TRUE(Import(kRoster).done);
  ImportResult result = Import("login,role\nada,student\nzoe,dean\nbob,\nbob,\n");
  EXPECT_FALSE(result.done);
  ASSERT_EQ(result.plan.problems.size(), 3u);
  EXPECT_EQ(result.plan.problems[0].row, 2u);
  EXPECT_NE(result.plan.problems[0].expected.find("instructor"), std::string::npos);
  EXPECT_EQ(result.plan.problems[1].row, 3u);
  EXPECT_EQ(result.plan.problems[2].row, 5u);
  EXPECT_EQ(result.plan.problems[2].column, "login");
  EXPECT_EQ(store_->people.PersonByLogin("ada")->role, Role::kInstructor);
}

TEST_F(ImportTest, CohortsThatPeopleTakeForOneAreToldAndNotMade) {
  ASSERT_TRUE(Import(kRoster).done);
  ImportResult result = Import("login,cohort\na,year 3\nb,Year  3\nc,Year 3\nd,Year 4\ne,YEAR 4\n");
  EXPECT_FALSE(result.done);
  ASSERT_EQ(result.plan.problems.size(), 3u);
  EXPECT_EQ(result.plan.problems[0].row, 2u);
  EXPECT_EQ(result.plan.problems[0].found, "\"year 3\"");
  EXPECT_NE(result.plan.problems[0].expected.find("\"Year 3\", which is there"), std::string::npos);
  EXPECT_EQ(result.plan.problems[1].row, 3u);
  EXPECT_EQ(result.plan.problems[2].row, 6u);
  EXPECT_NE(result.plan.problems[2].expected.find("as in row 5"), std::string::npos);
  EXPECT_EQ(store_->cohorts.Cohorts()->size(), 1u);
}

TEST_F(ImportTest, ArchivedCohortIsNotJoinedAndDisabledPeopleStaySo) {
  ASSERT_TRUE(Import(kRoster).done);
  Uuid bob = store_->people.PersonByLogin("bob")->id;
  ASSERT_TRUE(store_->people.SetDisabled(bob, true, kSystem).ok());
  ImportResult again = Import(kRoster);
  EXPECT_TRUE(again.done);
  EXPECT_NE(again.plan.steps[1].note.find("disabled"), std::string::npos);
  EXPECT_TRUE(store_->people.PersonById(bob)->disabled);
  Cohort cohort = store_->cohorts.Cohorts()->front();
  ASSERT_TRUE(
      store_->cohorts.EditCohort(cohort.id, {.archived = true}, cohort.revision, kSystem).ok());
  ImportResult refused = Import(kRoster);
  EXPECT_EQ(refused.plan.problems.size(), 2u);
  EXPECT_EQ(refused.plan.problems[0].column, "cohort");
}

TEST_F(ImportTest, OutcomeListsAtMostTwoHundredProblemsAndCountsAll) {
  std::string csv = "login\n";
  for (int i = 0; i < 300; ++i) csv += "not a login\n";
  auto outcome = ImportJson(Import(csv));
  EXPECT_EQ(outcome.at("problem_count"), 300);
  EXPECT_EQ(outcome.at("problems").as_array().size(), 200u);
  EXPECT_EQ(outcome.at("done"), false);
  auto good = ImportJson(Import(kRoster));
  EXPECT_EQ(good.at("created"), 2);
  EXPECT_EQ(good.at("people").at(0).at("change"), "create");
  EXPECT_EQ(good.at("new_cohorts").at(0), "Year 3");
}

}  // namespace
}  // namespace enamel::server::roster
