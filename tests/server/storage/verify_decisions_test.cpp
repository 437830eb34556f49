#include "common/base/file.h"
#include "common/base/hex.h"
#include "server/storage/engine/database.h"
#include "tests/server/storage/decided_school.h"

// `verify` finds edits of decisions, and of the inputs of scores, in the database
// (schemas/audit.md).
namespace enamel::server {
namespace {

using namespace testing;

class VerifyDecisionsTest : public DecidedSchoolTest {
 protected:
  VerifyDecisionsTest() { ExpectWhole("before anything is changed"); }

  // `verify` reports the edit with this kind and object and a text naming `column`. After undoing
  // the edit, everything agrees again.
  void ExpectEditFound(const std::string& table, const std::string& edit, const std::string& kind,
                       const std::string& object, const std::string& column) {
    SCOPED_TRACE(edit);
    const std::string free = "PRAGMA foreign_keys = 0; " + without_triggers_;
    Sql(free + "CREATE TABLE kept AS SELECT * FROM " + table + "; " + edit);
    const VerifyReport report = Look();
    EXPECT_TRUE(std::ranges::any_of(report.findings, [&](const Finding& finding) {
      return finding.kind == kind && finding.object == object &&
             finding.expected.find(column) != std::string::npos && !finding.remedy.empty();
    })) << Told(report);
    Sql(free + "DELETE FROM " + table + "; INSERT INTO " + table +
        " SELECT * FROM kept; DROP TABLE kept");
    ExpectWhole("put back");
  }
  // UPDATE table SET each of the edits, which begin with the column they change.
  void ExpectUpdatesFound(const std::string& table, const std::string& where,
                          const std::string& object, const std::vector<std::string>& edits) {
    for (const std::string& edit : edits) {
      const std::string column = edit.substr(0, edit.find(' '));
      ExpectEditFound(table, "UPDATE " + table + " SET " + edit + " WHERE " + where, "decision",
                      object, column);
    }
  }
};

TEST_F(VerifyDecisionsTest, ChangedOverrideReleaseAndTermsOfAnAttemptAreFound) {
  ExpectUpdatesFound("attempts", "id = " + Id(graded_), graded_.Text(),
                     {"override_score = 99",
                      "override_score = 70.000000000001",
                      "override_score = NULL",
                      "override_reason = 'fine'",
                      "override_reason = ''",
                      "override_by = " + Id(student()),
                      "override_by = NULL",
                      "override_ms = 1",
                      "released = 0",
                      "flags = 0",
                      "flags = flags | 64",
                      "flags = flags | 1",
                      "exam = 1",
                      "due_ms = 1",
                      "rate_hz = 1",
                      "limit_ticks = 1",
                      "hands = 1",
                      "sign_off = 1",
                      "ticketed_ms = 6",
                      "sealed_ms = 1",
                      "as_reference = 1",
                      "assignment = " + Id(assignment_),
                      "exercise = " + Id(other_.id),
                      "expired_ms = 5"});
}

TEST_F(VerifyDecisionsTest, ChangedStateOfAnAttemptIsFound) {
  for (const Uuid& attempt : {graded_, scored_, open_}) {
    const AttemptState is = school_.store->attempts.AttemptById(attempt)->state;
    for (int state = 1; state <= static_cast<int>(AttemptState::kQuarantined); ++state) {
      if (state == static_cast<int>(is)) continue;
      const bool decided = state == static_cast<int>(AttemptState::kQuarantined);
      ExpectEditFound(
          "attempts",
          "UPDATE attempts SET state = " + std::to_string(state) + " WHERE id = " + Id(attempt),
          "decision", attempt.Text(), decided ? "quarantined" : "state");
    }
  }
}

TEST_F(VerifyDecisionsTest, AttemptThatIsNoLongerQuarantinedIsFound) {
  Store& store = *school_.store;
  const ChunkPut another = school_.world.Chunk(open_, 0, HashSha256(AsBytes("other")), 1);
  ASSERT_EQ(store.ingest.AppendChunk(another).code(), Code::kConflict);
  ASSERT_EQ(store.attempts.AttemptById(open_)->state, AttemptState::kQuarantined);
  ExpectWhole("quarantined");
  for (const char* edit : {"state = 2", "state = 3", "state = 5", "state = 6"}) {
    ExpectEditFound("attempts",
                    "UPDATE attempts SET " + std::string(edit) + " WHERE id = " + Id(open_),
                    "decision", open_.Text(), "quarantined 1");
  }
}

TEST_F(VerifyDecisionsTest, AttemptThatWasTakenAwayWithAllThatHangsOnItIsFound) {
  const std::string id = Id(graded_);
  Sql("PRAGMA foreign_keys = 0; DELETE FROM appeals; DELETE FROM annotations; DELETE FROM jobs; "
      "DELETE FROM attempt_results WHERE attempt = " +
      id + "; DELETE FROM attempts WHERE id = " + id);
  ExpectFound("decision", graded_.Text());
}

TEST_F(VerifyDecisionsTest, ChangedCohortsAndMembersAreFound) {
  Store& store = *school_.store;
  const Actor by{teacher_, "page"};
  const Uuid cohort = *store.cohorts.CreateCohort("Year 9", by);
  ASSERT_TRUE(store.cohorts.AddToCohort(cohort, student(), by).ok());
  ASSERT_TRUE(store.cohorts.EditCohort(cohort, {std::nullopt, true}, 1, by).ok());
  ExpectWhole("archived");
  const std::string member = cohort.Text() + " " + student().Text();
  ExpectUpdatesFound("cohorts", "id = " + Id(cohort), cohort.Text(),
                     {"name = 'Year 8'", "archived_ms = 0"});
  ExpectEditFound("cohort_members",
                  "INSERT INTO cohort_members (tenant, cohort, person) VALUES (1, " + Id(cohort) +
                      ", " + Id(teacher_) + ")",
                  "decision", cohort.Text() + " " + teacher_.Text(), "member");
  ExpectEditFound("cohort_members", "DELETE FROM cohort_members WHERE cohort = " + Id(cohort),
                  "decision", member, "member");
  ASSERT_TRUE(store.cohorts.ChangeMembers(cohort, {}, {student()}, by).ok());
  ExpectWhole("removed");
  ExpectEditFound("cohort_members",
                  "INSERT INTO cohort_members (tenant, cohort, person) VALUES (1, " + Id(cohort) +
                      ", " + Id(student()) + ")",
                  "decision", member, "member");
  ExpectEditFound("cohorts",
                  "INSERT INTO cohorts (tenant, id, name) VALUES (1, " + Id(Uuid::New()) +
                      ", 'another'); UPDATE cohorts SET name = 'own' WHERE id = " + Id(cohort),
                  "decision", cohort.Text(), "name");
}

TEST_F(VerifyDecisionsTest, ChangedNamesRulesAndProfilesAreFound) {
  Store& store = *school_.store;
  ExpectUpdatesFound("people", "id = " + Id(student()), student().Text(),
                     {"display_name = 'Somebody else'"});
  ASSERT_TRUE(store.retention.SetRetention({"recordings", 730}, kSystem).ok());
  ExpectUpdatesFound("retention_rules", "what = 'recordings'", "recordings", {"days = 1"});
  ExpectEditFound("retention_rules",
                  "INSERT INTO retention_rules (tenant, what, days) VALUES (1, 'attempts', 1)",
                  "decision", "attempts", "retention");
  ExpectEditFound("retention_rules", "DELETE FROM retention_rules", "decision", "recordings",
                  "retention");
  ASSERT_TRUE(
      store.profiles.PutProfile({"omega", "Omega", PutText(store, "omega profile")}, kSystem).ok());
  ExpectEditFound("profile_versions",
                  "UPDATE profile_versions SET title = 'x' WHERE name = 'omega'", "decision",
                  "omega", "title");
}

TEST_F(VerifyDecisionsTest, ChangedCauseAndMotionOfARunAreFound) {
  ExpectEditFound("attempt_results",
                  "UPDATE attempt_results SET cause = 'appeal' WHERE attempt = " + Id(graded_),
                  "result", graded_.Text(), "cause");
  ExpectEditFound("motions",
                  "INSERT INTO motions (tenant, attempt, content, others, presets, preset_um, "
                  "tremor_nm, still_ppm, late_ppm, gap_ppm, nearest_um, median_um, "
                  "size_um) SELECT 1, " +
                      Id(graded_) + ", zeroblob(32), 3, 1, 1, 1, 1, 1, 1, 1, 2, 3",
                  "result", graded_.Text(), "motion");
}

TEST_F(VerifyDecisionsTest, ChangedAppealIsFound) {
  ExpectUpdatesFound("appeals", "attempt = " + Id(graded_), graded_.Text(),
                     {"state = 'regraded'", "state = 'open'", "answer = 'yes'", "answer = ''",
                      "text = 'all is well'", "filed_ms = 1", "answered_ms = 1",
                      "answered_by = " + Id(student())});
  ExpectEditFound("appeals", "DELETE FROM appeals", "decision", graded_.Text(), "appeal state");
}

TEST_F(VerifyDecisionsTest, ChangedSignatureAtTheChairIsFound) {
  Store& store = *school_.store;
  AttemptRow row = school_.world.AttemptOf(student());
  row.sign_off = true;
  ASSERT_TRUE(store.tickets.CreateAttempt(row, AsBytes("ticket"), kSystem).ok());
  ASSERT_TRUE(store.sign_offs.Sign(row.id, SignedAt::kStart, 7, {teacher_, "station"}).ok());
  ExpectWhole("signed");
  const std::string id = row.id.Text();
  for (const std::string edit : {"signer = randomblob(16)", "signed_ms = 8"}) {
    ExpectEditFound("sign_offs", "UPDATE sign_offs SET " + edit, "decision", id,
                    "sign_off start " + edit.substr(0, edit.find(' ')));
  }
  ExpectEditFound("sign_offs", "DELETE FROM sign_offs", "decision", id, "sign_off start");
  ExpectEditFound("sign_offs",
                  "INSERT INTO sign_offs SELECT tenant, attempt, 'end', signer, 9 FROM sign_offs",
                  "decision", id, "sign_off end");
}

TEST_F(VerifyDecisionsTest, ChangedRemarkIsFound) {
  ExpectUpdatesFound("annotations", "id = " + Id(remark_), remark_.Text(),
                     {"text = 'well done'", "author = " + Id(student()), "tick = 7",
                      "attempt = " + Id(scored_), "created_ms = 1", "x_um = 4"});
  ExpectEditFound("annotations", "DELETE FROM annotations", "decision", remark_.Text(),
                  "annotation");
}

TEST_F(VerifyDecisionsTest, SwappedReferenceIsFound) {
  const std::string at = "id = " + Id(reference_);
  const std::string name = "reference " + reference_.Text() + " ";
  ExpectEditFound("reference_cuts",
                  "UPDATE reference_cuts SET attempt = " + Id(graded_) + " WHERE " + at, "decision",
                  scored_.Text(), name + "exercise");
  ExpectEditFound("reference_cuts",
                  "UPDATE reference_cuts SET attempt = " + Id(graded_) + " WHERE " + at, "decision",
                  graded_.Text(), name + "exercise");
  for (const std::string edit : {"version = 7", "withdrawn_ms = 7", "created_ms = 7", "consent = 0",
                                 "dentist = 'Dr. Other'"}) {
    ExpectEditFound("reference_cuts", "UPDATE reference_cuts SET " + edit + " WHERE " + at,
                    "decision", scored_.Text(), name + edit.substr(0, edit.find(' ')));
  }
  ExpectEditFound("reference_cuts",
                  "UPDATE reference_cuts SET exercise = " + Id(other_.id) + " WHERE " + at,
                  "decision", scored_.Text(), name + "exercise");
  ExpectEditFound("reference_cuts", "DELETE FROM reference_cuts", "decision", scored_.Text(),
                  name + "version");
  ExpectEditFound("reference_cuts",
                  "INSERT INTO reference_cuts (tenant, id, exercise, attempt, dentist, version, "
                  "created_ms) VALUES (1, randomblob(16), " +
                      Id(school_.world.exercise.id) + ", " + Id(graded_) + ", 'me', 2, 5)",
                  "decision", graded_.Text(), "reference");
}

TEST_F(VerifyDecisionsTest, ReplacedRubricIsFound) {
  const std::string exercise = school_.world.exercise.id.Text();
  const Sha256 easier = PutText(*school_.store, "an easier rubric");
  for (const std::string& edit : {"content = x'" + easier.Hex() + "'", std::string("reason = 'x'"),
                                  std::string("published_ms = 1")}) {
    ExpectEditFound("rubrics", "UPDATE rubrics SET " + edit, "decision", exercise,
                    "rubric 2 " + edit.substr(0, edit.find(' ')));
  }
  ExpectEditFound("rubrics", "UPDATE rubrics SET version = 3", "decision", exercise,
                  "rubric 2 content");
  ExpectEditFound("rubrics", "DELETE FROM rubrics", "decision", exercise, "rubric 2 content");
  ExpectEditFound("rubrics",
                  "INSERT INTO rubrics SELECT tenant, exercise, 3, x'" + easier.Hex() +
                      "', reason, published_ms FROM rubrics",
                  "decision", exercise, "rubric 3 content");
}

TEST_F(VerifyDecisionsTest, RubricWhoseFileWasReplacedIsFound) {
  const Sha256 rubric = (*school_.store->rubrics.RubricFor(school_.world.exercise.id))->content;
  ASSERT_TRUE(WriteFileDurably(Blob(rubric), AsBytes("an easier rubric")).ok());
  ExpectOnly("blob", rubric.Hex());
}

TEST_F(VerifyDecisionsTest, ChangedExerciseIsFound) {
  ExpectUpdatesFound("exercises", "id = " + Id(other_.id), other_.id.Text(),
                     {"name = 'another'", "version = 2", "title = 'x'",
                      "content = x'" + school_.world.exercise.content.Hex() + "'",
                      "graded = 1 - graded", "published_ms = 1", "state = 3"});
  ExpectEditFound("exercises", "DELETE FROM exercises WHERE id = " + Id(other_.id), "decision",
                  other_.id.Text(), "exercise");
}

TEST_F(VerifyDecisionsTest, ChangedOwnerIsFound) {
  ExpectUpdatesFound("exercise_owners", "name = 'other'", "other",
                     {"owner = NULL", "owner = " + Id(student()), "shared = 1"});
  ExpectEditFound("exercise_owners", "DELETE FROM exercise_owners WHERE name = 'other'", "decision",
                  "other", "owner");
  ExpectEditFound("exercise_owners",
                  "INSERT INTO exercise_owners VALUES (1, 'mine', " + Id(student()) + ", 0)",
                  "decision", "mine", "owner");
}

TEST_F(VerifyDecisionsTest, ChangedTermsOfAnAssignmentAreFound) {
  const std::string id = assignment_.Text();
  ExpectUpdatesFound(
      "assignments", "id = " + Id(assignment_), id,
      {"exercise_name = 'other'", "exercise = " + Id(other_.id), "cohort = randomblob(16)",
       "opens_ms = 1", "due_ms = 0", "due_ms = due_ms + 1", "attempt_limit = 4",
       "attempt_limit = 0", "exam = 1", "late_allowed = 1", "hands = 4", "sign_off = 1",
       "outline = 'always'", "counting = 'last'", "created_ms = 1"});
  ExpectEditFound("assignments", "DELETE FROM assignments WHERE id = " + Id(assignment_),
                  "decision", id, "assignment");
  ExpectEditFound("assignment_stations", "DELETE FROM assignment_stations", "decision", id,
                  "station " + school_.world.station.Text());
  ExpectEditFound("assignment_stations",
                  "INSERT INTO assignment_stations VALUES (1, " + Id(assignment_) + ", x'" +
                      std::string(32, '7') + "')",
                  "database", "assignment_stations", "rows");
  ExpectEditFound(
      "assignments",
      "INSERT INTO assignments (tenant, id, exercise_name, exercise, cohort) VALUES (1, x'" +
          std::string(32, '7') + "', 'exercise', zeroblob(16), zeroblob(16))",
      "decision", "77777777-7777-7777-7777-777777777777", "this assignment");
}

TEST_F(VerifyDecisionsTest, ChangedListOfDevicesIsFound) {
  ExpectUpdatesFound("listed_devices", "1", "hid:1209:0001:A7",
                     {"title = 'chair 4'", "added_ms = 1"});
  ExpectEditFound("listed_devices", "UPDATE listed_devices SET name = 'mouse'", "decision",
                  "hid:1209:0001:A7", "device");
  ExpectEditFound("listed_devices", "UPDATE listed_devices SET name = 'mouse'", "decision", "mouse",
                  "this device");
  ExpectEditFound("listed_devices", "INSERT INTO listed_devices VALUES (1, 'mouse', 'x', 1)",
                  "decision", "mouse", "this device");
  ExpectEditFound("listed_devices", "DELETE FROM listed_devices", "decision", "hid:1209:0001:A7",
                  "device");
}

TEST_F(VerifyDecisionsTest, ChangedSettingOfStationsIsFound) {
  ExpectUpdatesFound("station_settings", "1", "language lab2-*", {"value = 'zh'", "fixed = 0"});
  ExpectEditFound("station_settings", "UPDATE station_settings SET scope = '*'", "decision",
                  "language *", "this setting");
  ExpectEditFound("station_settings", "DELETE FROM station_settings", "decision", "language lab2-*",
                  "setting");
}

TEST_F(VerifyDecisionsTest, StationThatIsAdmittedAgainIsFound) {
  ASSERT_TRUE(school_.store->stations.RevokeStation(school_.world.station, kSystem).ok());
  ExpectUpdatesFound("stations", "1", school_.world.station.Text(),
                     {"revoked = 0", "name = 'x'", "public_key = zeroblob(32)"});
}

TEST_F(VerifyDecisionsTest, PersonWhoMayMoreThanWasDecidedIsFound) {
  ExpectUpdatesFound("people", "id = " + Id(student()), student().Text(),
                     {"role = 3", "disabled = 1", "login = 'x'", "verifier = 'known to me'",
                      "pin = 'known to me'"});
  ExpectEditFound("people",
                  "INSERT INTO people (tenant, id, login, display_name, search_name, role, "
                  "created_ms, verifier) VALUES (1, x'" +
                      std::string(32, '7') + "', 'me', 'Me', 'me', 3, 1, 'known to me')",
                  "decision", "77777777-7777-7777-7777-777777777777", "this person");
}

// The last row about the override, which an edit of the trail would have to go with.
TEST_F(VerifyDecisionsTest, ChangedRowsOfTheTrailAreFound) {
  const AuditFilter filter{.action = "attempt.override", .object = graded_.Text()};
  const Uuid row = school_.store->audit.FindAudit(filter)->front().id;
  const std::string at = " WHERE id = " + Id(row);
  for (const std::string edit :
       {"before_json = '{\"score\":\"99\"}'", "after_json = '{}'", "state = ''",
        "state = replace(state, '\"override_score\":\"70\"', '\"override_score\":\"99\"')",
        "at_ms = at_ms + 1", "actor = zeroblob(16)", "via = 'command line'",
        "action = 'attempt.flag'", "object = 'x'", "subject = ''", "salt = randomblob(32)",
        "salt = NULL", "content_hash = randomblob(32)", "signature = randomblob(64)",
        "salt = NULL, before_json = '{\"erased\":true}', after_json = "
        "'{\"erased\":true}', state = '{\"erased\":true}'",
        "chain = randomblob(16)", "number = 7000", "previous = zeroblob(32)"}) {
    ExpectEditFound("audit", "UPDATE audit SET " + edit + at, "audit", row.Text(), "row attempt.");
  }
  ExpectEditFound("audit",
                  "UPDATE audit SET signature = (SELECT o.signature FROM audit o WHERE o.id < " +
                      Id(row) + " ORDER BY id DESC LIMIT 1)" + at,
                  "audit", row.Text(), "row attempt.override");
  ExpectEditFound("audit",
                  "INSERT INTO audit SELECT tenant, x'" + std::string(32, '7') +
                      "', at_ms, actor, via, action, object, before_json, after_json, subject, "
                      "state, salt, content_hash, signature, chain, 7000, previous FROM audit" +
                      at,
                  "audit", "77777777-7777-7777-7777-777777777777", "ticket.key signed it");
}

TEST_F(VerifyDecisionsTest, EditThatGoesWithAForgedRowIsFound) {
  const std::string forged =
      "INSERT INTO audit SELECT tenant, x'" + std::string(32, '7') +
      "', at_ms, actor, via, action, object, before_json, after_json, subject, replace(state, "
      "'\"override_score\":\"70\"', '\"override_score\":\"99\"'), salt, content_hash, signature, "
      "zeroblob(16), 1000, previous FROM audit WHERE action = 'appeal.answer'; UPDATE attempts SET "
      "override_score = 99 WHERE "
      "id = " +
      Id(graded_);
  Sql(forged);
  ExpectFound("audit", "77777777-7777-7777-7777-777777777777");
}

TEST_F(VerifyDecisionsTest, DecisionWhoseRowWasTakenAwayIsFound) {
  Sql(without_triggers_ +
      "DELETE FROM audit WHERE action IN ('attempt.override', 'attempt.flag', "
      "'appeal.file', 'appeal.answer')");
  ExpectFound("decision", graded_.Text());
}

TEST_F(VerifyDecisionsTest, TrailWithoutAnySignatureIsFound) {
  Sql(without_triggers_ +
      "UPDATE audit SET signature = zeroblob(64); UPDATE attempts SET override_score = "
      "99 WHERE override_score = 70");
  ExpectFound("audit", "enamel.db");
}

TEST_F(VerifyDecisionsTest, ErasingPeopleIsNoEdit) {
  Store& store = *school_.store;
  ASSERT_TRUE(store.erasures.ErasePerson(student(), true, kSystem).ok());
  ExpectWhole("the student");
  ASSERT_TRUE(store.erasures.ErasePerson(teacher_, true, kSystem).ok());
  ExpectWhole("the teacher, who owned an exercise");
  EXPECT_TRUE(store.exercises.ExerciseById(other_.id)->owner.IsZero());
}

TEST_F(VerifyDecisionsTest, ErasedRowsOfAPersonWhoIsPutBackAreFound) {
  Sql("CREATE TABLE kept AS SELECT * FROM people; UPDATE kept SET disabled = 0");
  ASSERT_TRUE(school_.store->erasures.ErasePerson(student(), true, kSystem).ok());
  Sql("INSERT INTO people SELECT * FROM kept WHERE id = " + Id(student()) + "; DROP TABLE kept");
  const VerifyReport report = Look();
  EXPECT_TRUE(std::ranges::any_of(report.findings, [](const Finding& finding) {
    return finding.kind == "audit" && finding.expected.find("was not erased") != std::string::npos;
  })) << Told(report);
}

TEST_F(VerifyDecisionsTest, WhatARetentionRuleRemovesIsNoEdit) {
  Store& store = *school_.store;
  ASSERT_TRUE(store.retention.SetRetention({"unfinished", 14}, kSystem).ok());
  ASSERT_TRUE(store.retention.SetRetention({"recordings", 1}, kSystem).ok());
  ASSERT_TRUE(store.retention.ApplyRetention(UnixMs{1} << 42, false, kSystem).ok());
  ASSERT_EQ(store.attempts.AttemptById(open_).status().code(), Code::kNotFound);
  ExpectWhole("two rules");
  ASSERT_TRUE(store.retention.SetRetention({"attempts", 400}, kSystem).ok());
  ASSERT_TRUE(store.retention.ApplyRetention(UnixMs{1} << 42, false, kSystem).ok());
  ASSERT_EQ(store.attempts.AttemptById(graded_).status().code(), Code::kNotFound);
  ExpectWhole("all rules");
}

TEST_F(VerifyDecisionsTest, EveryRowIsSignedAndCounted) {
  const VerifyReport report = Look();
  EXPECT_EQ(report.audit_rows, school_.store->audit.Audit(1000)->size());
  EXPECT_GE(report.decisions, 9u);
}

}  // namespace
}  // namespace enamel::server
