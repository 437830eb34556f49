#include "tests/server/storage/backends.h"
#include "tests/server/storage/store_world.h"

// Attempts that wait for their timeline, and storage of timelines; the same for every backend.
namespace enamel::server {
namespace {

using namespace testing;

constexpr UnixMs kLater = 40ll * 24 * 60 * 60 * 1000;

class TimelineStoreTest : public StoreSuite {
 protected:
  Uuid Made() {
    const Uuid attempt = world_.ScoredAttempt();
    EXPECT_EQ(store_->timelines.TakeTimeline()->value(), attempt);
    content_ = *store_->blobs.PutAttemptBlob(attempt, AsBytes("timeline of " + attempt.Text()));
    EXPECT_TRUE(store_->timelines.PutTimeline(attempt, content_).ok());
    return attempt;
  }

  World world_{*store_};
  Sha256 content_;
};
INSTANTIATE_TEST_SUITE_P(Backends, TimelineStoreTest, ::testing::ValuesIn(Backends()), BackendName);

TEST_P(TimelineStoreTest, AScoredAttemptWaitsForItsTimelineUntilItHasOne) {
  const Uuid opened = world_.OpenedAttempt();
  EXPECT_EQ(store_->timelines.TimelineOf(opened).status().code(), Code::kNotFound);
  EXPECT_FALSE(*store_->timelines.TakeTimeline()) << "nothing is scored";
  const Uuid attempt = world_.ScoredAttempt();
  EXPECT_TRUE(store_->timelines.TimelineOf(attempt)->waits);
  EXPECT_EQ(store_->timelines.TakeTimeline()->value(), attempt);
  EXPECT_TRUE(store_->timelines.TimelineOf(attempt)->waits) << "it is being made";
  const Sha256 content = *store_->blobs.PutAttemptBlob(attempt, AsBytes("timeline"));
  ASSERT_TRUE(store_->timelines.PutTimeline(attempt, content).ok());
  EXPECT_EQ(store_->timelines.TimelineOf(attempt)->content, content);
  EXPECT_FALSE(store_->timelines.TimelineOf(attempt)->waits);
  EXPECT_FALSE(*store_->timelines.TakeTimeline());
}

TEST_P(TimelineStoreTest, ScoringAgainKeepsTheTimeline) {
  const Uuid attempt = Made();
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, *store_->results.ResultOf(attempt), {}).ok());
  EXPECT_EQ(store_->timelines.TimelineOf(attempt)->content, content_);
  EXPECT_FALSE(*store_->timelines.TakeTimeline()) << "it follows from the recording alone";
}

TEST_P(TimelineStoreTest, TheNewestAttemptGoesFirst) {
  const Uuid older = world_.ScoredAttempt(), newer = world_.ScoredAttempt();
  EXPECT_EQ(store_->timelines.TakeTimeline()->value(), std::max(older, newer));
}

TEST_P(TimelineStoreTest, WhatWasAskedForGoesBeforeTheNewest) {
  std::set<Uuid> all;
  for (int i = 0; i < 3; ++i) all.insert(world_.ScoredAttempt());
  const Uuid oldest = *all.begin();
  ASSERT_TRUE(store_->timelines.AskForTimeline(oldest).ok());
  EXPECT_TRUE(store_->timelines.TimelineOf(oldest)->asked);
  EXPECT_EQ(store_->timelines.TakeTimeline()->value(), oldest);
  EXPECT_EQ(store_->timelines.TakeTimeline()->value(), *all.rbegin()) << "nobody asked for it";
}

TEST_P(TimelineStoreTest, AfterThreeTriesItIsGivenUpWithItsProblem) {
  const Uuid attempt = world_.ScoredAttempt();
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(store_->timelines.TakeTimeline()->value(), attempt) << i;
    ASSERT_TRUE(store_->timelines.FailTimeline(attempt, "disk full", true).ok());
  }
  EXPECT_FALSE(*store_->timelines.TakeTimeline());
  EXPECT_FALSE(store_->timelines.TimelineOf(attempt)->waits);
  EXPECT_EQ(store_->timelines.TimelineOf(attempt)->problem, "disk full");
}

TEST_P(TimelineStoreTest, ScoringAgainTriesAgainWhatWasGivenUp) {
  const Uuid attempt = world_.ScoredAttempt();
  ASSERT_TRUE(*store_->timelines.TakeTimeline());
  ASSERT_TRUE(store_->timelines.FailTimeline(attempt, "unknown core version", false).ok());
  ASSERT_FALSE(*store_->timelines.TakeTimeline());
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, *store_->results.ResultOf(attempt), {}).ok());
  EXPECT_TRUE(store_->timelines.TimelineOf(attempt)->waits);
  EXPECT_EQ(store_->timelines.TakeTimeline()->value(), attempt);
}

TEST_P(TimelineStoreTest, WhatNoTryCanHelpIsTriedOnce) {
  const Uuid attempt = world_.ScoredAttempt();
  ASSERT_TRUE(*store_->timelines.TakeTimeline());
  ASSERT_TRUE(store_->timelines.FailTimeline(attempt, "replay and recording part", false).ok());
  EXPECT_FALSE(*store_->timelines.TakeTimeline());
  EXPECT_FALSE(store_->timelines.TimelineOf(attempt)->waits);
}

TEST_P(TimelineStoreTest, WhatSomebodyMakesIsNotTakenByAnother) {
  const Uuid older = world_.ScoredAttempt(), newer = world_.ScoredAttempt();
  const std::set<Uuid> both{older, newer};
  const auto first = *store_->timelines.TakeTimeline(), second = *store_->timelines.TakeTimeline();
  ASSERT_TRUE(first && second);
  EXPECT_EQ((std::set<Uuid>{*first, *second}), both);
  EXPECT_FALSE(*store_->timelines.TakeTimeline());
  ASSERT_TRUE(store_->timelines.KeepTimeline(*first).ok());
  EXPECT_FALSE(*store_->timelines.TakeTimeline());
  ASSERT_TRUE(store_->timelines.FailTimeline(*first, "disk full", true).ok());
  EXPECT_EQ(*store_->timelines.TakeTimeline(), *first);
}

TEST_P(TimelineStoreTest, AStoppedTryDoesNotCount) {
  const Uuid attempt = world_.ScoredAttempt();
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(store_->timelines.TakeTimeline()->value(), attempt) << i;
    ASSERT_TRUE(store_->timelines.ReturnTimeline(attempt).ok());
  }
}

TEST_P(TimelineStoreTest, ItGoesWithTheRecording) {
  const Uuid attempt = Made(), waiting = world_.ScoredAttempt();
  for (const Uuid& id : {attempt, waiting}) {
    auto job = store_->jobs.LeaseJob(1, 1000);
    ASSERT_TRUE(job.ok() && job->has_value());
    ASSERT_TRUE(store_->results.FinishAttempt(id, *store_->results.ResultOf(id), {}).ok());
    ASSERT_TRUE(store_->jobs.FinishJob((*job)->lease, true, "").ok());
    ASSERT_TRUE(store_->judging.ReleaseAttempt(id, kSystem).ok());
  }
  ASSERT_TRUE(store_->retention.SetRetention({"recordings", 30}, kSystem).ok());
  ASSERT_EQ(store_->retention.ApplyRetention(kLater, false, kSystem)->recordings.size(), 2u);
  EXPECT_FALSE(store_->blobs.HasBlob(content_));
  EXPECT_EQ(store_->timelines.TimelineOf(attempt).status().code(), Code::kNotFound);
  EXPECT_FALSE(*store_->timelines.TakeTimeline());
  EXPECT_EQ(store_->timelines.PutTimeline(waiting, content_).code(), Code::kConflict)
      << "removed while it was made";
}

TEST_P(TimelineStoreTest, ItGoesWithThePerson) {
  const Uuid attempt = Made();
  EXPECT_TRUE(store_->blobs.GetBlob(content_).ok());
  auto erased = store_->erasures.ErasePerson(world_.student, false, kSystem);
  ASSERT_TRUE(erased.ok()) << erased.status().message();
  EXPECT_FALSE(store_->blobs.HasBlob(content_));
  EXPECT_EQ(store_->timelines.TimelineOf(attempt).status().code(), Code::kNotFound);
}

TEST_P(TimelineStoreTest, AStartToothIsFoundByItsVolumeAndKept) {
  const Sha256 volume = PutText(*store_, "volume"), tooth = PutText(*store_, "start tooth");
  EXPECT_TRUE(store_->timelines.StartToothOf(volume)->IsZero());
  EXPECT_FALSE(*store_->timelines.IsStartTooth(tooth));
  ASSERT_TRUE(store_->timelines.PutStartTooth(volume, tooth).ok());
  ASSERT_TRUE(store_->timelines.PutStartTooth(volume, tooth).ok()) << "the same again";
  EXPECT_EQ(*store_->timelines.StartToothOf(volume), tooth);
  EXPECT_TRUE(*store_->timelines.IsStartTooth(tooth));
  EXPECT_FALSE(*store_->timelines.IsStartTooth(volume)) << "only what is one";
  // What no row names is swept away after a day.
  ASSERT_TRUE(store_->retention.ApplyRetention(kLater, false, kSystem).ok());
  EXPECT_TRUE(store_->blobs.HasBlob(tooth));
}

}  // namespace
}  // namespace enamel::server
