#include <gtest/gtest.h>

#include <algorithm>

#include "server/training/revision.h"
#include "tests/server/storage/backends.h"

// What every backend of Store must do with people, sessions, cohorts, rosters, stations, codes and
// device profiles that are edited.
namespace enamel::server {
namespace {

using namespace testing;

class PeopleStoreTest : public StoreSuite {
 protected:
  std::vector<std::string> Logins(const PeopleFilter& filter) {
    std::vector<std::string> out;
    auto people = store_->people.FindPeople(filter);
    EXPECT_TRUE(people.ok()) << people.status().message();
    for (const Person& person : *people) out.push_back(person.login);
    return out;
  }
  // The newest row about the object.
  AuditRow LastAudit(const std::string& object) {
    AuditFilter filter;
    filter.object = object;
    filter.limit = 1;
    auto rows = store_->audit.FindAudit(filter);
    return rows->empty() ? AuditRow{} : rows->front();
  }
};
INSTANTIATE_TEST_SUITE_P(Backends, PeopleStoreTest, ::testing::ValuesIn(Backends()), BackendName);

TEST_P(PeopleStoreTest, NobodyIsGivenANameThatIsDrawnAsAnothers) {
  const std::string copa = "\u0421\u043e\u0440\u0430";  // Cyrillic
  AddPerson(*store_, "copa", Role::kAdmin);
  const Uuid ben = AddPerson(*store_, "ben", Role::kStudent);
  const Status renamed =
      store_->people.EditPerson(ben, {.display_name = copa}, 1, kSystem).status();
  EXPECT_EQ(renamed.code(), Code::kConflict);
  EXPECT_EQ(renamed.field(), "display_name");
  Person another;
  another.login = "other";
  another.display_name = copa;
  EXPECT_EQ(store_->people.CreatePerson(another, "", {}, kSystem).status().field(), "display_name");
  // Two people of one name are no disguise.
  another.display_name = store_->people.PersonById(ben)->display_name;
  EXPECT_TRUE(store_->people.CreatePerson(another, "", {}, kSystem).ok());
}

TEST_P(PeopleStoreTest, EditCountsTheRevisionAndAStaleOneChangesNothing) {
  Uuid id = AddPerson(*store_, "ada", Role::kInstructor);
  auto renamed = store_->people.EditPerson(id, {.display_name = "Ada B."}, 1, kSystem);
  ASSERT_TRUE(renamed.ok()) << renamed.status().message();
  EXPECT_EQ(renamed->revision, 2);
  Status stale = store_->people.EditPerson(id, {.display_name = "Ada C."}, 1, kSystem).status();
  EXPECT_EQ(stale.code(), Code::kConflict);
  EXPECT_EQ(stale.field(), kStale);
  Reopen();
  EXPECT_EQ(store_->people.PersonById(id)->display_name, "Ada B.");
  EXPECT_NE(LastAudit(id.Text()).before_json.find("Name of ada"), std::string::npos);
  EXPECT_NE(LastAudit(id.Text()).after_json.find("Ada B."), std::string::npos);
  EXPECT_EQ(store_->people.EditPerson(id, {.display_name = "Ada B."}, 2, kSystem)->revision, 2)
      << "nothing changed";
  EXPECT_EQ(store_->people.EditPerson(Uuid::New(), {}, 1, kSystem).status().code(),
            Code::kNotFound);
}

TEST_P(PeopleStoreTest, NamesAreFoundWhateverTheirCaseAndAccents) {
  const Uuid id = AddPerson(*store_, "zn1", Role::kStudent);
  AddPerson(*store_, "other", Role::kStudent);
  ASSERT_TRUE(store_->people.EditPerson(id, {.display_name = "Zoë  ÑANDÚ-Groß"}, 1, kSystem).ok());
  Reopen();
  for (const char* text : {"zoe", "ñandu", "GROSS zoë", "zoe  nandu", " ZN1 gros "}) {
    EXPECT_EQ(Logins({.text = text}), std::vector<std::string>{"zn1"}) << text;
  }
  EXPECT_EQ(Logins({.text = "zoe name"}), std::vector<std::string>{}) << "each of the words";
  EXPECT_EQ(Logins({.text = " "}).size(), 2u);
}

TEST_P(PeopleStoreTest, AnotherRoleAndDisablingEndTheSessionsAnotherNameDoesNot) {
  Uuid id = AddPerson(*store_, "ada", Role::kStudent);
  auto sessions_after = [&](const PersonEdit& edit) {
    EXPECT_TRUE(
        store_->sessions.CreateSession({HashSha256(AsBytes("t")), id, 1, 1, 1000, "page"}).ok());
    Person now = *store_->people.PersonById(id);
    EXPECT_TRUE(store_->people.EditPerson(id, edit, now.revision, kSystem).ok());
    size_t left = store_->sessions.SessionsOf(id)->size();
    EXPECT_TRUE(store_->sessions.EndSessionsOf(id, kSystem).ok());
    return left;
  };
  EXPECT_EQ(sessions_after({.display_name = "Else"}), 1u);
  EXPECT_EQ(sessions_after({.role = Role::kInstructor}), 0u);
  EXPECT_EQ(sessions_after({.disabled = true}), 0u);
}

TEST_P(PeopleStoreTest, LastAdminWhoMaySignInIsKept) {
  Uuid root = AddPerson(*store_, "root", Role::kAdmin);
  EXPECT_EQ(store_->people.SetDisabled(root, true, kSystem).code(), Code::kConflict);
  EXPECT_EQ(
      store_->people.EditPerson(root, {.role = Role::kInstructor}, 1, kSystem).status().code(),
      Code::kConflict);
  Uuid other = AddPerson(*store_, "other", Role::kAdmin);
  ASSERT_TRUE(store_->people.SetDisabled(other, true, kSystem).ok());
  EXPECT_EQ(store_->people.SetDisabled(root, true, kSystem).code(), Code::kConflict)
      << "the other one may not sign in";
  ASSERT_TRUE(store_->people.SetDisabled(other, false, kSystem).ok());
  EXPECT_TRUE(store_->people.SetDisabled(root, true, kSystem).ok());
}

TEST_P(PeopleStoreTest, FiltersNarrowAndPagesFollowByLogin) {
  Uuid cohort = *store_->cohorts.CreateCohort("year 1", kSystem);
  for (const char* login : {"cleo", "ada", "bob", "dan"}) {
    Uuid id = AddPerson(*store_, login, login[0] == 'a' ? Role::kInstructor : Role::kStudent);
    if (login[0] < 'c') {
      ASSERT_TRUE(store_->cohorts.AddToCohort(cohort, id, kSystem).ok());
    }
    if (login[0] == 'd') {
      ASSERT_TRUE(store_->people.SetDisabled(id, true, kSystem).ok());
    }
  }
  using Names = std::vector<std::string>;
  EXPECT_EQ(Logins({}), (Names{"ada", "bob", "cleo", "dan"}));
  EXPECT_EQ(Logins({.role = Role::kStudent}), (Names{"bob", "cleo", "dan"}));
  EXPECT_EQ(Logins({.cohort = cohort}), (Names{"ada", "bob"}));
  EXPECT_EQ(Logins({.disabled = true}), (Names{"dan"}));
  EXPECT_EQ(Logins({.text = "NAME OF C"}), (Names{"cleo"}));
  EXPECT_EQ(Logins({.text = "%"}), Names{}) << "no pattern, plain text";
  EXPECT_EQ(Logins({.after_login = "bob", .limit = 1}), (Names{"cleo"}));
  EXPECT_EQ(Logins({.role = Role::kStudent, .cohort = cohort, .text = "b"}), (Names{"bob"}));
}

TEST_P(PeopleStoreTest, PasswordForOneUseIsMarkedUntilAnotherIsSet) {
  Uuid id = AddPerson(*store_, "ada", Role::kStudent);
  EXPECT_FALSE(store_->people.PersonById(id)->must_change_password);
  ASSERT_TRUE(store_->people.SetPassword(id, "v", true, kSystem).ok());
  Reopen();
  EXPECT_TRUE(store_->people.PersonById(id)->must_change_password);
  ASSERT_TRUE(store_->people.SetPassword(id, "w", false, kSystem).ok());
  EXPECT_FALSE(store_->people.PersonById(id)->must_change_password);
}

TEST_P(PeopleStoreTest, ALanguageStaysWithThePersonWhoChoseIt) {
  Uuid ada = AddPerson(*store_, "ada", Role::kStudent);
  Uuid sam = AddPerson(*store_, "sam", Role::kStudent);
  EXPECT_EQ(store_->people.PersonById(ada)->language, "");
  ASSERT_TRUE(store_->people.SetLanguage(ada, "zh").ok());
  Reopen();
  EXPECT_EQ(store_->people.PersonById(ada)->language, "zh");
  EXPECT_EQ(store_->people.PersonById(sam)->language, "");
  EXPECT_EQ(store_->people.SetLanguage(Uuid::New(), "de").code(), Code::kNotFound);
  EXPECT_FALSE(store_->people.SetLanguage(ada, "xx").ok()) << "the database has no such language";
}

TEST_P(PeopleStoreTest, ASessionSaysFromWhereAndWithWhatUntilThePersonIsErased) {
  Uuid ada = AddPerson(*store_, "ada", Role::kStudent);
  SessionRow row{HashSha256(AsBytes("1")), ada, 10, 10, 1000, "page"};
  row.address = "203.0.113.7";
  row.device = "Firefox on Linux";
  ASSERT_TRUE(store_->sessions.CreateSession(row).ok());
  Reopen();
  const SessionRow kept = store_->sessions.SessionsOf(ada)->at(0);
  EXPECT_EQ(kept.address, row.address);
  EXPECT_EQ(kept.device, row.device);
  EXPECT_EQ(LastAudit(ada.Text()).action, "session.begin");
  EXPECT_EQ(LastAudit(ada.Text()).after_json, R"({"address":"203.0.113.7"})");
  ASSERT_TRUE(store_->erasures.ErasePerson(ada, false, kSystem).ok());
  const std::vector<AuditRow> trail = *store_->audit.Audit(100);
  for (const AuditRow& told : trail) {
    EXPECT_EQ((told.before_json + told.after_json).find("203.0.113"), std::string::npos)
        << told.action;
  }
}

TEST_P(PeopleStoreTest, SessionsAreListedConfirmedAndEndedByName) {
  Uuid ada = AddPerson(*store_, "ada", Role::kStudent),
       bob = AddPerson(*store_, "bob", Role::kStudent);
  Sha256 first = HashSha256(AsBytes("1")), second = HashSha256(AsBytes("2"));
  ASSERT_TRUE(store_->sessions.CreateSession({first, ada, 10, 10, 1000, "page"}).ok());
  ASSERT_TRUE(store_->sessions.CreateSession({second, ada, 20, 20, 1000, "station"}).ok());
  ASSERT_TRUE(
      store_->sessions.CreateSession({HashSha256(AsBytes("3")), bob, 30, 30, 1000, "page"}).ok());
  auto sessions = *store_->sessions.SessionsOf(ada);
  ASSERT_EQ(sessions.size(), 2u);
  EXPECT_EQ(sessions[0].token_hash, second) << "newest first";
  EXPECT_EQ(sessions[1].confirmed_ms, 10) << "the password was given to begin it";
  EXPECT_NE(sessions[0].id, sessions[1].id);
  ASSERT_TRUE(store_->sessions.ConfirmSession(first, 500).ok());
  EXPECT_EQ(store_->sessions.SessionById(sessions[1].id)->confirmed_ms, 500);
  ASSERT_TRUE(store_->sessions.EndSessionById(sessions[1].id, kSystem).ok());
  EXPECT_EQ(store_->sessions.EndSessionById(sessions[1].id, kSystem).code(), Code::kNotFound);
  EXPECT_FALSE(store_->sessions.FindSession(first).ok());
  EXPECT_TRUE(store_->sessions.FindSession(second).ok());
  EXPECT_EQ(*store_->sessions.EndSessionsOf(ada, kSystem), 1u);
  EXPECT_EQ(store_->sessions.SessionsOf(bob)->size(), 1u);
  EXPECT_EQ(LastAudit(ada.Text()).action, "session.end");
}

TEST_P(PeopleStoreTest, CohortIsRenamedArchivedAndOpenedAgain) {
  Uuid id = *store_->cohorts.CreateCohort("year 1", kSystem);
  ASSERT_TRUE(store_->cohorts.CreateCohort("year 2", kSystem).ok());
  auto archived =
      store_->cohorts.EditCohort(id, {.name = "class of 2030", .archived = true}, 1, kSystem);
  ASSERT_TRUE(archived.ok()) << archived.status().message();
  EXPECT_GT(archived->archived_ms, 0);
  EXPECT_EQ(archived->revision, 2);
  EXPECT_EQ(store_->cohorts.EditCohort(id, {.archived = false}, 1, kSystem).status().field(),
            kStale);
  Status taken = store_->cohorts.EditCohort(id, {.name = "year 2"}, 2, kSystem).status();
  EXPECT_EQ(taken.code(), Code::kConflict);
  EXPECT_NE(taken.field(), kStale);
  Reopen();
  EXPECT_EQ(store_->cohorts.CohortById(id)->name, "class of 2030");
  EXPECT_EQ(store_->cohorts.EditCohort(id, {.archived = false}, 2, kSystem)->archived_ms, 0);
}

TEST_P(PeopleStoreTest, CohortsAreCountedInTheOrderAskedForAndWhoTeachesIsNoStudent) {
  const Uuid full = *store_->cohorts.CreateCohort("full", kSystem),
             empty = *store_->cohorts.CreateCohort("empty", kSystem),
             other = *store_->cohorts.CreateCohort("other", kSystem);
  const auto member = [&](const char* login, Role role, const std::vector<Uuid>& cohorts) {
    const Uuid id = AddPerson(*store_, login, role);
    for (const Uuid& in : cohorts) ASSERT_TRUE(store_->cohorts.AddToCohort(in, id, kSystem).ok());
  };
  member("sam", Role::kStudent, {full, other});
  member("sue", Role::kStudent, {full});
  member("ben", Role::kInstructor, {full});
  member("ada", Role::kInstructor, {full, other});
  member("root", Role::kAdmin, {full});
  const auto sizes = store_->cohorts.SizesOf({other, empty, full});
  ASSERT_TRUE(sizes.ok()) << sizes.status().message();
  ASSERT_EQ(sizes->size(), 3u);
  EXPECT_EQ((*sizes)[0].students, 1u);
  EXPECT_EQ((*sizes)[0].instructors, std::vector<std::string>{"Name of ada"});
  EXPECT_EQ((*sizes)[1].students, 0u);
  EXPECT_TRUE((*sizes)[1].instructors.empty());
  EXPECT_EQ((*sizes)[2].students, 2u);
  EXPECT_EQ((*sizes)[2].instructors, (std::vector<std::string>{"Name of ada", "Name of ben"}));
}

TEST_P(PeopleStoreTest, ArchivedCohortIsGivenNothingToDo) {
  World world(*store_);
  Uuid cohort = *store_->cohorts.CreateCohort("year 1", kSystem);
  ASSERT_TRUE(store_->cohorts.AddToCohort(cohort, world.student, kSystem).ok());
  ASSERT_TRUE(
      store_->exercises.PublishExercise(world.Exercise("closed", "c1"), cohort, kSystem).ok());
  size_t before = store_->assignments.AssignmentsFor(world.student)->size();
  ASSERT_TRUE(store_->cohorts.EditCohort(cohort, {.archived = true}, 1, kSystem).ok());
  EXPECT_EQ(store_->assignments.AssignmentsFor(world.student)->size(), before - 1);
  ASSERT_TRUE(store_->cohorts.EditCohort(cohort, {.archived = false}, 2, kSystem).ok());
  EXPECT_EQ(store_->assignments.AssignmentsFor(world.student)->size(), before);
}

TEST_P(PeopleStoreTest, MembersChangeAllOrNotAtAll) {
  Uuid cohort = *store_->cohorts.CreateCohort("year 1", kSystem);
  Uuid ada = AddPerson(*store_, "ada", Role::kStudent),
       bob = AddPerson(*store_, "bob", Role::kStudent);
  ASSERT_TRUE(store_->cohorts.ChangeMembers(cohort, {ada}, {}, kSystem).ok());
  Status unknown = store_->cohorts.ChangeMembers(cohort, {bob, Uuid::New()}, {ada}, kSystem);
  EXPECT_EQ(unknown.code(), Code::kNotFound);
  EXPECT_EQ(store_->cohorts.CohortMembers(cohort)->front().id, ada);
  EXPECT_EQ(store_->cohorts.CohortMembers(cohort)->size(), 1u);
  ASSERT_TRUE(store_->cohorts.ChangeMembers(cohort, {bob, bob}, {ada}, kSystem).ok());
  EXPECT_EQ(store_->cohorts.CohortMembers(cohort)->front().id, bob);
  EXPECT_EQ(store_->cohorts.ChangeMembers(Uuid::New(), {ada}, {}, kSystem).code(), Code::kNotFound);
}

std::vector<RosterRow> Roster() {
  return {{2, "ada", "Ada", Role::kInstructor, "year 1", "v2"},
          {3, "bob", "Bob", Role::kStudent, "year 1", "v3"},
          {4, "cleo", "Cleo", Role::kStudent, "year 2", "v4"}};
}

TEST_P(PeopleStoreTest, RosterIsImportedOnceAndAgainChangesNothing) {
  auto dry = store_->roster.ImportRoster(Roster(), {.dry_run = true}, kSystem);
  ASSERT_TRUE(dry.ok()) << dry.status().message();
  EXPECT_EQ(dry->Count(RosterStep::Change::kCreate), 3u);
  EXPECT_TRUE(store_->people.People()->empty()) << "only tried";

  auto done = store_->roster.ImportRoster(Roster(), {}, kSystem);
  ASSERT_TRUE(done.ok()) << done.status().message();
  EXPECT_EQ(done->new_cohorts, (std::vector<std::string>{"year 1", "year 2"}));
  Person bob = *store_->people.PersonByLogin("bob");
  EXPECT_TRUE(bob.must_change_password);
  EXPECT_EQ(*store_->people.PasswordVerifier(bob.id), "v3");
  auto cohort_of = [&](const char* login) {
    return store_->cohorts.CohortsOf(store_->people.PersonByLogin(login)->id)->front().name;
  };
  EXPECT_EQ(cohort_of("bob"), cohort_of("ada"));
  EXPECT_NE(cohort_of("bob"), cohort_of("cleo"));

  size_t audited = store_->audit.Audit(1000)->size();
  auto again = store_->roster.ImportRoster(Roster(), {}, kSystem);
  EXPECT_EQ(again->Count(RosterStep::Change::kUnchanged), 3u);
  EXPECT_EQ(store_->audit.Audit(1000)->size(), audited);
  EXPECT_EQ(*store_->people.PasswordVerifier(bob.id), "v3") << "who is there keeps the password";
}

TEST_P(PeopleStoreTest, RosterRenamesAndAddsAndTakesNobodyAway) {
  ASSERT_TRUE(store_->roster.ImportRoster(Roster(), {}, kSystem).ok());
  Uuid bob = store_->people.PersonByLogin("bob")->id;
  ASSERT_TRUE(store_->roster
                  .ImportRoster({{2, "bob", "Bob B.", Role::kStudent, "year 2", "x"}}, {}, kSystem)
                  .ok());
  EXPECT_EQ(store_->people.PersonById(bob)->display_name, "Bob B.");
  EXPECT_EQ(store_->cohorts.CohortsOf(bob)->size(), 2u);
  EXPECT_EQ(store_->people.People()->size(), 3u);
  ASSERT_TRUE(
      store_->roster.ImportRoster({{2, "bob", "", Role::kStudent, "", "x"}}, {}, kSystem).ok());
  EXPECT_EQ(store_->people.PersonById(bob)->display_name, "Bob B.") << "an empty name is none";
}

TEST_P(PeopleStoreTest, RosterWithAProblemChangesNothingAtAll) {
  AddPerson(*store_, "ada", Role::kStudent);
  auto refused = store_->roster.ImportRoster(Roster(), {}, kSystem);
  ASSERT_TRUE(refused.ok()) << refused.status().message();
  ASSERT_EQ(refused->problems.size(), 1u);
  EXPECT_EQ(refused->problems[0].row, 2u);
  EXPECT_EQ(refused->problems[0].column, "role");
  EXPECT_EQ(store_->people.People()->size(), 1u);
  EXPECT_TRUE(store_->cohorts.Cohorts()->empty());
}

// Who reads a name at a chair or in a list must know which one is meant.
TEST_P(PeopleStoreTest, NoTwoStationsGetOneNameByRenaming) {
  World world(*store_);
  const Sha256 code = HashSha256(AsBytes("another code"));
  ASSERT_TRUE(store_->stations.AddEnrolCode(code, 1'000, kSystem).ok());
  StationRow other;
  other.name = "Bench 2";
  const trace::KeyPair its = trace::NewKeyPair();
  other.public_key.assign(its.public_key.begin(), its.public_key.end());
  const auto second =
      store_->stations.EnrolStation(code, other, HashSha256(AsBytes("its credential")), 10);
  ASSERT_TRUE(second.ok()) << second.status().message();
  const auto refused = store_->stations.RenameStation(world.station, "Bench 2", 1, kSystem);
  EXPECT_EQ(refused.status().code(), Code::kConflict);
  EXPECT_EQ(refused.status().field(), "name");
  ASSERT_TRUE(store_->stations.RevokeStation(second->id, kSystem).ok());
  EXPECT_TRUE(store_->stations.RenameStation(world.station, "Bench 2", 1, kSystem).ok());
}

TEST_P(PeopleStoreTest, StationIsRenamedAndRevokedForGood) {
  World world(*store_);
  auto renamed = store_->stations.RenameStation(world.station, "Bench 7", 1, kSystem);
  ASSERT_TRUE(renamed.ok()) << renamed.status().message();
  EXPECT_EQ(store_->stations.RenameStation(world.station, "Bench 8", 1, kSystem).status().field(),
            kStale);
  ASSERT_TRUE(store_->stations.TouchStation(world.station, "enamel-station 0.1.0", 3, 77).ok());
  EXPECT_EQ(*store_->stations.RevokedStations(), std::vector<Uuid>{});
  ASSERT_TRUE(store_->stations.RevokeStation(world.station, kSystem).ok());
  ASSERT_TRUE(store_->stations.RevokeStation(world.station, kSystem).ok())
      << "again changes nothing";
  EXPECT_EQ(*store_->stations.RevokedStations(), std::vector<Uuid>{world.station});
  Reopen();
  StationRow row = *store_->stations.StationById(world.station);
  EXPECT_EQ(row.name, "Bench 7");
  EXPECT_EQ(row.software, "enamel-station 0.1.0");
  EXPECT_EQ(row.core_version, 3u);
  EXPECT_EQ(row.last_seen_ms, 77);
  EXPECT_TRUE(row.revoked);
  EXPECT_GT(row.revoked_ms, 0);
}

TEST_P(PeopleStoreTest, EnrolmentCodesAreListedWhileTheyWorkAndWithdrawn) {
  Sha256 a = HashSha256(AsBytes("a")), b = HashSha256(AsBytes("b"));
  Uuid late = *store_->stations.AddEnrolCode(a, 2000, kSystem),
       soon = *store_->stations.AddEnrolCode(b, 1000, kSystem);
  auto open = *store_->stations.OpenEnrolCodes(500);
  ASSERT_EQ(open.size(), 2u);
  EXPECT_EQ(open[0].id, soon);
  EXPECT_EQ(store_->stations.OpenEnrolCodes(1500)->size(), 1u) << "one has expired";
  ASSERT_TRUE(store_->stations.WithdrawEnrolCode(soon, kSystem).ok());
  StationRow row;
  row.name = "s";
  row.public_key.assign(32, 7);
  EXPECT_EQ(store_->stations.EnrolStation(b, row, a, 500).status().code(), Code::kUnauthenticated);
  ASSERT_TRUE(store_->stations.EnrolStation(a, row, a, 500).ok());
  EXPECT_TRUE(store_->stations.OpenEnrolCodes(500)->empty());
  EXPECT_EQ(store_->stations.WithdrawEnrolCode(late, kSystem).code(), Code::kConflict);
  EXPECT_EQ(store_->stations.WithdrawEnrolCode(Uuid::New(), kSystem).code(), Code::kNotFound);
}

TEST_P(PeopleStoreTest, ProfileKeepsEveryContentItHad) {
  auto put = [&](const std::string& text) {
    return store_->profiles.PutProfile({"omega", "Omega", PutText(*store_, text)}, kSystem);
  };
  ASSERT_TRUE(put("one").ok());
  ASSERT_TRUE(put("two").ok());
  ASSERT_TRUE(put("two").ok());
  ASSERT_TRUE(put("one").ok()) << "an older content may come back";
  auto versions = *store_->profiles.ProfileVersions("omega");
  ASSERT_EQ(versions.size(), 3u);
  EXPECT_EQ(versions[0].version, 3);
  EXPECT_EQ(versions[0].content, versions[2].content);
  EXPECT_EQ(versions[1].content, PutText(*store_, "two"));
  ASSERT_EQ(store_->profiles.Profiles()->size(), 1u);
  EXPECT_EQ(store_->profiles.Profiles()->front().version, 3);
  EXPECT_TRUE(store_->profiles.ProfileVersions("none")->empty());
}

TEST_P(PeopleStoreTest, ReportsAndCalibrationsStayWithTheirProfile) {
  ProfileReportRow report{{}, "omega", 0, "text/html", PutText(*store_, "<html>"), 6};
  CalibrationRow calibration{{}, "omega", "hid:1", 1000, 0, "{}"};
  EXPECT_EQ(store_->profiles.AddProfileReport(report, kSystem).status().code(), Code::kNotFound);
  EXPECT_EQ(store_->profiles.AddCalibration(calibration, kSystem).status().code(), Code::kNotFound);
  ASSERT_TRUE(
      store_->profiles.PutProfile({"omega", "Omega", PutText(*store_, "one")}, kSystem).ok());
  auto added = store_->profiles.AddProfileReport(report, kSystem);
  ASSERT_TRUE(added.ok()) << added.status().message();
  EXPECT_EQ(store_->profiles.AddProfileReport(report, kSystem)->id, added->id) << "twice is once";
  ASSERT_TRUE(
      store_->profiles.PutProfile({"omega", "Omega", PutText(*store_, "two")}, kSystem).ok());
  EXPECT_EQ(store_->profiles.AddProfileReport(report, kSystem)->version, 2)
      << "about what counts now";
  report.content = HashSha256(AsBytes("not stored"));
  EXPECT_EQ(store_->profiles.AddProfileReport(report, kSystem).status().code(), Code::kNotFound);

  auto first = store_->profiles.AddCalibration(calibration, kSystem);
  ASSERT_TRUE(first.ok()) << first.status().message();
  EXPECT_EQ(store_->profiles.AddCalibration(calibration, kSystem)->id, first->id);
  calibration.measured_ms = 2000;
  calibration.document = "{ }";
  ASSERT_TRUE(store_->profiles.AddCalibration(calibration, kSystem).ok());
  Reopen();
  auto calibrations = *store_->profiles.Calibrations("omega");
  ASSERT_EQ(calibrations.size(), 2u);
  EXPECT_EQ(calibrations[0].measured_ms, 2000);
  EXPECT_EQ(store_->profiles.ProfileReports("omega")->size(), 2u);
  EXPECT_EQ(store_->profiles.ProfileReportById(added->id)->media_type, "text/html");
}

TEST_P(PeopleStoreTest, AuditIsFoundByActorActionObjectAndTime) {
  Uuid root = AddPerson(*store_, "root", Role::kAdmin);
  Actor by{root, "page"};
  Uuid cohort = *store_->cohorts.CreateCohort("year 1", by);
  ASSERT_TRUE(store_->cohorts.EditCohort(cohort, {.name = "year 2"}, 1, by).ok());
  ASSERT_TRUE(store_->cohorts.AddToCohort(cohort, root, kSystem).ok());
  auto actions = [&](const AuditFilter& filter) {
    std::vector<std::string> out;
    auto rows = store_->audit.FindAudit(filter);
    EXPECT_TRUE(rows.ok()) << rows.status().message();
    for (const AuditRow& row : *rows) out.push_back(row.action);
    return out;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(actions({.actor = root}), (Names{"cohort.edit", "cohort.create"}));
  EXPECT_EQ(actions({.action = "cohort."}), (Names{"cohort.add", "cohort.edit", "cohort.create"}));
  EXPECT_EQ(actions({.action = "cohort"}), Names{});
  EXPECT_EQ(actions({.actor = root, .action = "cohort.edit"}), (Names{"cohort.edit"}));
  EXPECT_EQ(actions({.object = root.Text()}), (Names{"person.create"}));
  UnixMs at = LastAudit(cohort.Text()).at_ms;
  EXPECT_EQ(actions({.object = cohort.Text(), .from_ms = at + 100'000}), Names{});
  EXPECT_EQ(actions({.object = cohort.Text(), .until_ms = at - 100'000}), Names{});
  AuditFilter page;
  page.limit = 1;
  Names walked;
  for (auto rows = *store_->audit.FindAudit(page); !rows.empty();
       rows = *store_->audit.FindAudit(page)) {
    walked.push_back(rows[0].action);
    page.before = rows[0].id;
  }
  EXPECT_EQ(walked, actions({}));
}

TEST_P(PeopleStoreTest, ErasingAPersonTakesTheNameOutOfTheAuditTrailAndLeavesTheRows) {
  Uuid ada = AddPerson(*store_, "ada", Role::kStudent);
  Uuid bob = AddPerson(*store_, "bob", Role::kStudent);
  ASSERT_TRUE(store_->people.EditPerson(ada, {.display_name = "Ada Secret"}, 1, kSystem).ok());
  ASSERT_TRUE(store_->people.EditPerson(bob, {.display_name = "Bob Stays"}, 1, kSystem).ok());
  size_t before = store_->audit.Audit(1000)->size();
  ASSERT_TRUE(store_->erasures.ErasePerson(ada, false, kSystem).ok());
  auto rows = *store_->audit.Audit(1000);
  EXPECT_EQ(rows.size(), before + 1) << "the erasure itself";
  bool bobs = false;
  for (const AuditRow& row : rows) {
    EXPECT_EQ(row.before_json.find("ada"), std::string::npos) << row.before_json;
    EXPECT_EQ(row.after_json.find("Ada Secret"), std::string::npos) << row.after_json;
    bobs |= row.after_json.find("Bob Stays") != std::string::npos;
  }
  EXPECT_TRUE(bobs);
}

TEST_P(PeopleStoreTest, JobsAreFoundByStateAndInPages) {
  World world(*store_);
  for (int i = 0; i < 3; ++i) {
    Uuid attempt = world.OpenedAttempt();
    ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  }
  ASSERT_TRUE(store_->jobs.LeaseJob(1, 1000)->has_value());
  EXPECT_EQ(store_->jobs.FindJobs({.state = "queued"})->size(), 2u);
  JobFilter page;
  page.limit = 2;
  auto first = *store_->jobs.FindJobs(page);
  ASSERT_EQ(first.size(), 2u);
  page.before = first.back().id;
  auto second = *store_->jobs.FindJobs(page);
  ASSERT_EQ(second.size(), 1u);
  EXPECT_EQ(second[0].state, "running") << "the oldest was taken first";
}

TEST_P(PeopleStoreTest, TheOnlyAdminIsNotErased) {
  Uuid admin = AddPerson(*store_, "admin", Role::kAdmin);
  Status refused = store_->erasures.ErasePerson(admin, false, kSystem).status();
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_TRUE(store_->people.PersonById(admin).ok());
  Uuid other = AddPerson(*store_, "other", Role::kAdmin);
  EXPECT_TRUE(store_->erasures.ErasePerson(admin, false, kSystem).ok());
  ASSERT_TRUE(store_->people.PersonById(other).ok());
  EXPECT_EQ(store_->erasures.ErasePerson(other, false, kSystem).status().code(), Code::kConflict);
}

TEST_P(PeopleStoreTest, StationComesBackUnderItsOldIdWithItsKeyAndANewCode) {
  Sha256 codes[4];
  for (int i = 0; i < 4; ++i) {
    codes[i] = HashSha256(AsBytes("code " + std::to_string(i)));
    ASSERT_TRUE(store_->stations.AddEnrolCode(codes[i], 1000, kSystem).ok());
  }
  StationRow row;
  row.id = Uuid::New();  // of before a restore: nothing is known of it
  row.name = "bench";
  row.public_key.assign(32, 7);
  Sha256 first = HashSha256(AsBytes("first")), second = HashSha256(AsBytes("second"));
  auto back = store_->stations.EnrolStation(codes[0], row, first, 10);
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_EQ(back->id, row.id);
  ASSERT_TRUE(store_->stations.EnrolStation(codes[1], row, second, 20).ok())
      << "known: the same key";
  EXPECT_FALSE(store_->stations.StationByCredential(row.id, first).ok());
  EXPECT_TRUE(store_->stations.StationByCredential(row.id, second).ok());
  EXPECT_EQ(store_->stations.EnrolStation(codes[1], row, first, 25).status().code(),
            Code::kUnauthenticated)
      << "a code works once";
  StationRow forged = row;
  forged.public_key.assign(32, 8);
  EXPECT_EQ(store_->stations.EnrolStation(codes[2], forged, first, 30).status().code(),
            Code::kConflict);
  ASSERT_TRUE(store_->stations.RevokeStation(row.id, kSystem).ok());
  EXPECT_EQ(store_->stations.EnrolStation(codes[3], row, first, 40).status().code(),
            Code::kConflict)
      << "revoked for good";
  EXPECT_EQ(store_->stations.OpenEnrolCodes(50)->size(), 2u) << "what was refused uses up no code";
}

}  // namespace
}  // namespace enamel::server
