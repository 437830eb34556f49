#include <sqlite3.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <utility>

#include "server/training/access.h"
#include "tests/server/storage/backends.h"
#include "tests/server/storage/store_world.h"

// Retention rules; the same for every backend.
namespace enamel::server {
namespace {

using namespace testing;

constexpr UnixMs kDay = 24ll * 60 * 60 * 1000;

class RetentionTest : public StoreSuite {
 protected:
  // Scored, its job done, sealed 200 ms after the epoch.
  Uuid Scored() {
    Uuid attempt = world_.ScoredAttempt();
    AttemptResult result = *store_->results.ResultOf(attempt);
    result.deviation = *store_->blobs.PutAttemptBlob(attempt, AsBytes("deviation"));
    EXPECT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
    auto job = store_->jobs.LeaseJob(1, 1000);
    EXPECT_TRUE(job.ok() && job->has_value());
    EXPECT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
    EXPECT_TRUE(store_->jobs.FinishJob((*job)->lease, true, "").ok());
    return attempt;
  }
  // Records, seals and scores an attempt that has its ticket.
  void Score(const Uuid& attempt) {
    ASSERT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
    ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world_.Append(attempt, 1)), 200).ok());
    auto job = store_->jobs.LeaseJob(1, 1000);
    ASSERT_TRUE(job.ok() && job->has_value());
    AttemptResult result;
    result.score = 80;
    result.score_json = PutText(*store_, "score");
    ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, (*job)->lease).ok());
    ASSERT_TRUE(store_->jobs.FinishJob((*job)->lease, true, "").ok());
  }
  Uuid Released() {
    Uuid attempt = Scored();
    EXPECT_TRUE(store_->judging.ReleaseAttempt(attempt, kSystem).ok());
    return attempt;
  }
  RetentionReport Apply(UnixMs now, bool dry_run = false) {
    auto report = store_->retention.ApplyRetention(now, dry_run, kSystem);
    EXPECT_TRUE(report.ok()) << report.status().message();
    return *report;
  }
  void Rule(const char* what, int days) {
    Status set = store_->retention.SetRetention({what, days}, kSystem);
    EXPECT_TRUE(set.ok()) << set.message();
  }

  World world_{*store_};
};
INSTANTIATE_TEST_SUITE_P(Backends, RetentionTest, ::testing::ValuesIn(Backends()), BackendName);

TEST_P(RetentionTest, WithoutARuleEverythingIsKept) {
  Uuid attempt = Released();
  RetentionReport report = Apply(100'000 * kDay);
  EXPECT_TRUE(report.attempts.empty() && report.recordings.empty() && report.unfinished.empty());
  EXPECT_TRUE(AllChunks(store_->recordings, attempt).ok());
}

TEST_P(RetentionTest, RecordingGoesAfterItsDaysAndTheScoreStays) {
  Uuid attempt = Released();
  Sha256 deviation = store_->results.ResultOf(attempt)->deviation;
  Rule("recordings", 30);
  EXPECT_TRUE(Apply(30 * kDay).recordings.empty()) << "sealed at 200 ms: not yet";
  EXPECT_EQ(Apply(30 * kDay + 201, true).recordings, std::vector{attempt}) << "only told";
  EXPECT_TRUE(AllChunks(store_->recordings, attempt).ok());
  RetentionReport report = Apply(30 * kDay + 201);
  EXPECT_EQ(report.recordings, std::vector{attempt});
  EXPECT_GE(report.blobs, 2u) << "trace and deviation";
  auto gone = AllChunks(store_->recordings, attempt);
  EXPECT_EQ(gone.status().code(), Code::kNotFound);
  EXPECT_NE(gone.status().message().find("retention"), std::string::npos);
  EXPECT_FALSE(store_->blobs.HasBlob(deviation));
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->score, 80);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->expired_ms, 30 * kDay + 201);
  EXPECT_TRUE(store_->blobs.GetBlob(store_->results.ResultOf(attempt)->score_json).ok());
  EXPECT_EQ(store_->references.AddReference(attempt, "Dr. Example", true, kSystem).status().code(),
            Code::kConflict);
  EXPECT_TRUE(Apply(40 * kDay).recordings.empty()) << "once";
}

TEST_P(RetentionTest, WholeAttemptGoesAndOnlyItsOwnBlobs) {
  Uuid attempt = Released();
  Rule("attempts", 8);
  Rule("recordings", 1);
  RetentionReport report = Apply(9 * kDay);
  EXPECT_EQ(report.attempts, std::vector{attempt});
  EXPECT_TRUE(report.recordings.empty()) << "counted once";
  EXPECT_EQ(store_->attempts.AttemptById(attempt).status().code(), Code::kNotFound);
  EXPECT_TRUE(store_->blobs.HasBlob(world_.scene)) << "documents stay";
}

TEST_P(RetentionTest, ReferenceAndWhatAJobNeedsAreKept) {
  Uuid reference = Scored();
  ASSERT_TRUE(store_->references.AddReference(reference, "Dr. Example", true, kSystem).ok());
  Uuid queued = world_.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world_.Append(queued, 1)), 200).ok());
  Rule("attempts", 8);
  Rule("recordings", 1);
  RetentionReport report = Apply(1000 * kDay);
  EXPECT_TRUE(report.attempts.empty());
  EXPECT_TRUE(report.recordings.empty());
  EXPECT_TRUE(AllChunks(store_->recordings, reference).ok());
}

TEST_P(RetentionTest, GradedWorkIsKeptUntilItIsReleasedOrExcused) {
  Uuid released = Scored(), excused = Scored(), waiting = Scored();
  Rule("recordings", 30);
  RetentionReport due = Apply(40 * kDay, true);
  EXPECT_TRUE(due.recordings.empty());
  EXPECT_EQ(due.held, 3u);
  ASSERT_TRUE(store_->judging.ReleaseAttempt(released, kSystem).ok());
  ASSERT_TRUE(store_->judging.FlagAttempt(excused, kExcused, "was ill", kSystem).ok());
  RetentionReport report = Apply(40 * kDay);
  EXPECT_EQ(report.recordings, (std::vector{released, excused}));
  EXPECT_EQ(report.held, 1u);
  EXPECT_TRUE(AllChunks(store_->recordings, waiting).ok());
  Rule("attempts", 60);
  EXPECT_EQ(Apply(61 * kDay).attempts, (std::vector{released, excused}));
  EXPECT_TRUE(AllChunks(store_->recordings, waiting).ok());
}

// The same rule is in access.h and, for the database, in retention_rows.cpp.
TEST_P(RetentionTest, StudentsWorkIsHeldExactlyWhereAccessReleasesItFirst) {
  ExerciseRow practice = world_.Exercise("practice", "p1");
  practice.graded = false;
  const Uuid exercises[] = {store_->exercises.PublishExercise(practice, Uuid{}, kSystem)->id,
                            world_.exercise.id};
  const Uuid people[] = {AddPerson(*store_, "ada", Role::kInstructor), world_.student};
  AssignmentRow assignment;
  assignment.exercise = world_.exercise.name;
  const Uuid assigned = store_->assignments.AddAssignment(assignment, kSystem)->id;
  std::map<Uuid, bool> held;
  for (unsigned bits = 0; bits < 64; ++bits) {
    auto bit = [&](unsigned i) { return (bits >> i & 1) != 0; };
    const bool graded = bit(0), student = bit(1), released = bit(2);
    AttemptRow row;
    row.id = Uuid::New();
    row.person = people[student];
    row.station = world_.station;
    row.exercise = exercises[graded];
    row.profile_content = world_.profile;
    row.ticketed_ms = 5;
    row.exam = bit(3);
    row.flags = bit(4) ? kReadmitted : 0;
    if (bit(5)) row.assignment = assigned;
    ASSERT_TRUE(store_->tickets.CreateAttempt(row, AsBytes("ticket"), kSystem).ok());
    Score(row.id);
    if (released) ASSERT_TRUE(store_->judging.ReleaseAttempt(row.id, kSystem).ok());
    held[row.id] = student && !released && IsReleasedFirst(row, graded);
  }
  Rule("recordings", 30);
  RetentionReport due = Apply(40 * kDay, true);
  EXPECT_EQ(due.recordings.size() + due.held, 64u);
  for (const Uuid& id : due.recordings) EXPECT_FALSE(held[id]) << id.Text();
  EXPECT_EQ(due.held, static_cast<size_t>(
                          std::ranges::count_if(held, [](const auto& one) { return one.second; })));
}

TEST_P(RetentionTest, WhatAnAppealIsAboutIsKeptUntilItsAnswer) {
  Uuid attempt = Released();
  ASSERT_TRUE(store_->appeals.FileAppeal(attempt, "please look again", kSystem).ok());
  Rule("recordings", 1);
  Rule("attempts", 8);
  EXPECT_TRUE(Apply(100 * kDay).attempts.empty());
  EXPECT_TRUE(AllChunks(store_->recordings, attempt).ok());
  ASSERT_TRUE(store_->appeals.AnswerAppeal(attempt, false, "it stays", kSystem).ok());
  EXPECT_EQ(Apply(100 * kDay).attempts, std::vector{attempt});
}

TEST_P(RetentionTest, PracticeAndWhatTeachersTryGoWithoutARelease) {
  ExerciseRow practice = world_.Exercise("practice", "p1");
  practice.graded = false;
  ExerciseRow graded =
      std::exchange(world_.exercise, *store_->exercises.PublishExercise(practice, Uuid{}, kSystem));
  Uuid practised = Scored();
  world_.exercise = graded;
  world_.student = AddPerson(*store_, "ada", Role::kInstructor);
  Uuid tried = Scored();
  Rule("recordings", 1);
  EXPECT_EQ(Apply(2 * kDay).recordings, (std::vector{practised, tried}));
}

TEST_P(RetentionTest, WhatWasNeverScoredBecauseItsJobWasCancelledGoesToo) {
  ExerciseRow practice = world_.Exercise("practice", "p1");
  practice.graded = false;
  world_.exercise = *store_->exercises.PublishExercise(practice, Uuid{}, kSystem);
  Uuid attempt = world_.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world_.Append(attempt, 1)), 200).ok());
  Rule("recordings", 30);
  EXPECT_TRUE(Apply(40 * kDay).recordings.empty()) << "its job waits";
  ASSERT_TRUE(store_->jobs.CancelJob(store_->jobs.Jobs("queued")->front().id, kSystem).ok());
  EXPECT_EQ(Apply(40 * kDay).recordings, std::vector{attempt});
  EXPECT_EQ(AllChunks(store_->recordings, attempt).status().code(), Code::kNotFound);
  EXPECT_EQ(store_->judging.Rescore(attempt, "rescore", kSystem).code(), Code::kConflict);
  Rule("attempts", 60);
  EXPECT_EQ(Apply(61 * kDay).attempts, std::vector{attempt});
}

TEST(RetentionOfEvidenceTest, ChunksThatContradictedASealedRecordingGoWithIt) {
  TempFolder folder;
  auto store = OpenStore(folder.path());
  World world(*store);
  Uuid attempt = world.ScoredAttempt();
  auto job = store->jobs.LeaseJob(1, 1000);
  ASSERT_TRUE(store->jobs.FinishJob((*job)->lease, true, "").ok());
  ASSERT_TRUE(store->results.FinishAttempt(attempt, *store->results.ResultOf(attempt), {}).ok());
  ASSERT_TRUE(store->judging.ReleaseAttempt(attempt, kSystem).ok());
  EXPECT_FALSE(store->ingest.AppendChunk(world.Chunk(attempt, 0, World::HeaderHash(), 9)).ok());
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder.path() / "enamel.db").c_str(), &db), SQLITE_OK);
  auto kept = [&] {
    int count = -1;
    auto take = [](void* out, int, char** text, char**) {
      *static_cast<int*>(out) = std::atoi(text[0]);
      return 0;
    };
    sqlite3_exec(db, "SELECT count(*) FROM contradicting_chunks", take, &count, nullptr);
    return count;
  };
  EXPECT_EQ(kept(), 1);
  ASSERT_TRUE(store->retention.SetRetention({"recordings", 30}, kSystem).ok());
  EXPECT_EQ(store->retention.ApplyRetention(40 * kDay, false, kSystem)->recordings,
            std::vector{attempt});
  EXPECT_EQ(kept(), 0);
  sqlite3_close(db);
}

TEST_P(RetentionTest, UnfinishedGoesButNotWhatIsQuarantined) {
  Uuid unfinished = world_.OpenedAttempt(), contradicted = world_.OpenedAttempt();
  world_.Append(contradicted, 1);
  EXPECT_FALSE(
      store_->ingest.AppendChunk(world_.Chunk(contradicted, 0, World::HeaderHash(), 9)).ok());
  Rule("unfinished", 14);
  EXPECT_TRUE(Apply(14 * kDay).unfinished.empty()) << "ticketed at 5 ms";
  EXPECT_EQ(Apply(14 * kDay + 6).unfinished, std::vector{unfinished});
  EXPECT_EQ(store_->attempts.AttemptById(contradicted)->state, AttemptState::kQuarantined);
  Rule("attempts", 8);
  EXPECT_EQ(Apply(14 * kDay + 6).attempts, std::vector{contradicted});
}

TEST_P(RetentionTest, RulesAreCheckedKeptAndAudited) {
  EXPECT_EQ(store_->retention.SetRetention({"everything", 3}, kSystem).code(), Code::kInvalidInput);
  EXPECT_EQ(store_->retention.SetRetention({"unfinished", 13}, kSystem).code(), Code::kInvalidInput)
      << "stations may still upload";
  EXPECT_EQ(store_->retention.SetRetention({"attempts", 7}, kSystem).code(), Code::kInvalidInput)
      << "a station would bring it back";
  EXPECT_EQ(store_->retention.SetRetention({"attempts", -1}, kSystem).code(), Code::kInvalidInput);
  Rule("attempts", 365);
  Rule("recordings", 30);
  Rule("recordings", 0);
  Reopen();
  auto rules = store_->retention.RetentionRules();
  ASSERT_EQ(rules->size(), 1u);
  EXPECT_EQ(rules->front().what, "attempts");
  EXPECT_EQ(rules->front().days, 365);
  AuditRow last = store_->audit.Audit(1)->front();
  EXPECT_EQ(last.action, "retention.set");
  EXPECT_NE(last.before_json.find("30"), std::string::npos);
}

}  // namespace
}  // namespace enamel::server
