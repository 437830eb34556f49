#include <gtest/gtest.h>

#include <algorithm>

#include "server/training/revision.h"
#include "tests/server/storage/backends.h"

// What every backend of Store must do when a decision about an attempt is taken back: an excuse,
// and a score that was made again.
namespace enamel::server {
namespace {

using namespace testing;

class UndoTest : public StoreSuite {
 protected:
  // A run of the job that waits, with so many points.
  void Run(double points) {
    const auto job = *store_->jobs.LeaseJob(1, 1000);
    ASSERT_TRUE(job.has_value());
    AttemptResult result;
    result.score = points;
    const std::string of = " of " + std::to_string(points);
    result.score_json = PutText(*store_, "score" + of);
    result.final_volume = PutText(*store_, "tooth");
    result.deviation = PutText(*store_, "deviation" + of);
    result.series = PutText(*store_, "series" + of);
    result.scored_ms = 300 + static_cast<UnixMs>(points);
    ASSERT_TRUE(store_->results.FinishAttempt(attempt_, result, job->lease).ok());
    ASSERT_TRUE(store_->jobs.FinishJob(job->lease, true, "").ok());
  }
  void RunAgain(double points) {
    ASSERT_TRUE(store_->judging.Rescore(attempt_, "rescore", kSystem).ok());
    Run(points);
  }
  void Sealed() {
    attempt_ = world_.OpenedAttempt();
    ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world_.Append(attempt_, 1)), 200).ok());
  }
  AttemptRow Row() { return *store_->attempts.AttemptById(attempt_); }

  World world_{*store_};
  Uuid attempt_;
};

TEST_P(UndoTest, ExcuseThatIsTakenBackLeavesTheAttemptAsItWas) {
  Sealed();
  const AttemptRow before = Row();
  ASSERT_TRUE(store_->judging.FlagAttempt(attempt_, kExcused, "was ill", kSystem).ok());
  const int32_t seen = Row().revision;
  EXPECT_EQ(store_->judging.ClearExcuse(attempt_, kSystem, seen - 1).field(), kStale);
  ASSERT_TRUE(store_->judging.ClearExcuse(attempt_, kSystem, seen).ok());
  EXPECT_EQ(Row().flags, before.flags);
  EXPECT_EQ(Row().revision, seen + 1);
  ASSERT_TRUE(store_->judging.ClearExcuse(attempt_, kSystem).ok());
  EXPECT_EQ(Row().revision, seen + 1) << "it was not excused";
  EXPECT_EQ(store_->audit.Audit(1)->front().action, "attempt.unflag");
  EXPECT_EQ(store_->judging.ClearExcuse(Uuid::New(), kSystem).code(), Code::kNotFound);
}

TEST_P(UndoTest, EarlierScoreCountsAgainWithAllThatBelongsToIt) {
  Sealed();
  Run(70);
  const auto first = *store_->results.ResultOf(attempt_);
  RunAgain(50);
  EXPECT_EQ(Row().score, 50);
  EXPECT_TRUE(store_->results.ResultsOf(attempt_)->back().is_whole);
  const int32_t seen = Row().revision;
  EXPECT_EQ(store_->results.RestoreResult(attempt_, 1, kSystem, seen - 1).field(), kStale);
  ASSERT_TRUE(store_->results.RestoreResult(attempt_, 1, kSystem, seen).ok());
  EXPECT_EQ(Row().score, 70);
  EXPECT_EQ(Row().state, AttemptState::kScored);
  EXPECT_GT(Row().revision, seen);
  const auto now = *store_->results.ResultOf(attempt_);
  EXPECT_EQ(now.score_json, first.score_json);
  EXPECT_EQ(now.deviation, first.deviation);
  EXPECT_EQ(now.series, first.series);
  EXPECT_EQ(now.scored_ms, first.scored_ms);
  const auto runs = *store_->results.ResultsOf(attempt_);
  ASSERT_EQ(runs.size(), 3u) << "what was taken back stays in the history";
  EXPECT_EQ(runs.front().cause, "restore");
  EXPECT_EQ(runs[1].score, 50);
  EXPECT_EQ(store_->audit.Audit(1)->front().action, "attempt.restore");
  // And once more, the other way round.
  ASSERT_TRUE(store_->results.RestoreResult(attempt_, 2, kSystem).ok());
  EXPECT_EQ(Row().score, 50);
}

TEST_P(UndoTest, RunThatWaitsIsCancelledAndTheScoreStays) {
  Sealed();
  Run(70);
  ASSERT_TRUE(store_->judging.Rescore(attempt_, "rescore", kSystem).ok());
  ASSERT_TRUE(store_->results.RestoreResult(attempt_, 1, kSystem).ok());
  EXPECT_TRUE(store_->jobs.Jobs("queued")->empty());
  EXPECT_EQ(store_->results.ResultsOf(attempt_)->size(), 1u);
  EXPECT_EQ(Row().score, 70);
  // One that is under way.
  ASSERT_TRUE(store_->judging.Rescore(attempt_, "rescore", kSystem).ok());
  ASSERT_TRUE(store_->jobs.LeaseJob(1, 1000)->has_value());
  EXPECT_EQ(Row().state, AttemptState::kScoring);
  ASSERT_TRUE(store_->results.RestoreResult(attempt_, 1, kSystem).ok());
  EXPECT_EQ(Row().state, AttemptState::kScored);
  EXPECT_TRUE(store_->jobs.Jobs("running")->empty());
}

TEST_P(UndoTest, RunsFromBeforeTheLastTwoAreRefusedAsOnlyTheirScoreIsKept) {
  Sealed();
  Run(70);
  RunAgain(50);
  RunAgain(40);
  EXPECT_FALSE(store_->results.ResultsOf(attempt_)->back().is_whole);
  const Status refused = store_->results.RestoreResult(attempt_, 1, kSystem);
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_EQ(refused.field(), "run");
  EXPECT_EQ(store_->results.RestoreResult(attempt_, 9, kSystem).code(), Code::kNotFound);
  EXPECT_EQ(Row().score, 40);
}

TEST_P(UndoTest, PicturesOfARunThatMayCountAgainAreNotSweptAway) {
  Sealed();
  Run(70);
  const auto first = *store_->results.ResultOf(attempt_);
  RunAgain(50);
  ASSERT_TRUE(store_->retention.ApplyRetention(UnixMs{1} << 42, false, kSystem).ok());
  EXPECT_TRUE(store_->blobs.GetBlob(first.deviation).ok());
  ASSERT_TRUE(store_->erasures.ErasePerson(world_.student, true, kSystem).ok());
  EXPECT_FALSE(store_->blobs.GetBlob(first.deviation).ok());
}

TEST_P(UndoTest, ReleaseOfGradedWorkGoesWithTheScoreThatWasReleased) {
  ExerciseRow graded = world_.Exercise("graded", "graded work");
  graded.graded = true;
  world_.exercise = *store_->exercises.PublishExercise(graded, Uuid{}, kSystem);
  Sealed();
  Run(70);
  RunAgain(50);
  ASSERT_TRUE(store_->judging.ReleaseAttempt(attempt_, kSystem).ok());
  ASSERT_TRUE(store_->results.RestoreResult(attempt_, 1, kSystem).ok());
  EXPECT_FALSE(Row().released) << "another score than the student has seen";
}

INSTANTIATE_TEST_SUITE_P(Backends, UndoTest, ::testing::ValuesIn(Backends()), BackendName);

}  // namespace
}  // namespace enamel::server
