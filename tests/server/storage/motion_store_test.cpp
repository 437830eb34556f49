#include "server/storage/engine/query.h"
#include "server/storage/store_engine.h"
#include "tests/server/storage/backends.h"
#include "tests/server/storage/store_world.h"

// Motions of attempts, which earlier ones an attempt is compared with, and their deletion; the same
// for every backend.
namespace enamel::server {
namespace {

using namespace testing;

constexpr UnixMs kFortyDays = 40ll * 24 * 60 * 60 * 1000;

constexpr scoring::HandFigures kCalm = {1'500, 250'000, 30, 40};

class MotionStoreTest : public StoreSuite {
 protected:
  // A scored attempt with a motion that is its own, and `near` as its nearest.
  Uuid Moved(const std::optional<NearAttempt>& near = {}) {
    const Uuid attempt = world_.ScoredAttempt();
    Finish(attempt, near);
    return attempt;
  }
  void Finish(const Uuid& attempt, const std::optional<NearAttempt>& near) {
    auto result = *store_->results.ResultOf(attempt);
    result.motion = Content(attempt);
    result.near = near;
    result.hand = kCalm;
    ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
  }
  Sha256 Content(const Uuid& attempt) {
    return *store_->blobs.PutAttemptBlob(attempt, AsBytes("motion of " + attempt.Text()));
  }
  std::vector<Uuid> Before(const Uuid& attempt, uint32_t limit = 100) {
    std::vector<Uuid> out;
    auto rows = store_->motions.MotionsBefore(attempt, limit);
    EXPECT_TRUE(rows.ok()) << rows.status().message();
    for (const MotionRow& row : *rows) {
      out.push_back(row.attempt);
      EXPECT_EQ(row.content, Content(row.attempt));
    }
    return out;
  }
  bool Flagged(const Uuid& attempt) {
    return (store_->attempts.AttemptById(attempt)->flags & kNearAnother) != 0;
  }

  World world_{*store_};
};
INSTANTIATE_TEST_SUITE_P(Backends, MotionStoreTest, ::testing::ValuesIn(Backends()), BackendName);

NearAttempt Near(const Uuid& attempt, bool worth_a_look) {
  return {attempt, 7, 12, 900, 1400, worth_a_look};
}

TEST_P(MotionStoreTest, WhatWasSealedBeforeIsFoundNewestFirst) {
  const Uuid first = Moved(), second = Moved(), without = world_.ScoredAttempt(), last = Moved();
  EXPECT_TRUE(Before(first).empty());
  EXPECT_EQ(Before(second), std::vector{first});
  EXPECT_EQ(Before(last), (std::vector{second, first})) << "one has no motion";
  EXPECT_EQ(Before(last, 1), std::vector{second});
  EXPECT_EQ(Before(without), (std::vector{second, first}));
}

TEST_P(MotionStoreTest, ASwingFlagsTheAttemptAndIsShownAtItsListedDevice) {
  const Uuid attempt = Moved(), other = Moved();
  ASSERT_TRUE(store_->engine->rows
                  .Write([&](sql::Db& db) {
                    return Query(db,
                                 "UPDATE attempts SET hand_unit = 'hid:1', hand_device = 'omega3' "
                                 "WHERE tenant = ?1 AND id = ?2")
                        .Bind(attempt)
                        .Run();
                  })
                  .ok());
  for (const char* name : {"hid:1", "omega3"})
    ASSERT_TRUE(store_->devices.ListDevice(name, name, kSystem).ok());
  const auto ran = [&](bool shook) {
    auto result = *store_->results.ResultOf(attempt);
    result.shook = shook;
    EXPECT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
    return (store_->attempts.AttemptById(attempt)->flags & kShook) != 0;
  };
  const auto shown = [&] {
    std::vector<UnixMs> out;
    for (const ListedDevice& device : *store_->devices.ListedDevices())
      out.push_back(device.shook_ms);
    return out;
  };
  EXPECT_EQ(shown(), (std::vector<UnixMs>{0, 0}));
  EXPECT_TRUE(ran(true));
  EXPECT_EQ(shown(), (std::vector<UnixMs>{store_->attempts.AttemptById(attempt)->ticketed_ms, 0}));
  EXPECT_EQ(store_->attempts.AttemptById(other)->flags & kShook, 0u);
  EXPECT_FALSE(ran(false)) << "it was scored again";
  EXPECT_EQ(shown(), (std::vector<UnixMs>{0, 0}));
}

TEST_P(MotionStoreTest, WhatLiesNearestIsKeptAndFlagsTheAttempt) {
  const Uuid first = Moved(), copy = Moved(Near(first, true)), other = Moved(Near(first, false));
  EXPECT_FALSE(*store_->motions.NearestTo(first)) << "there was none before it";
  EXPECT_FALSE(Flagged(first));
  EXPECT_EQ(*store_->motions.NearestTo(copy), Near(first, true));
  EXPECT_TRUE(Flagged(copy));
  EXPECT_EQ(*store_->motions.NearestTo(other), Near(first, false));
  EXPECT_FALSE(Flagged(other));
}

TEST_P(MotionStoreTest, TheNewestRunSaysWhetherItIsNear) {
  const Uuid first = Moved(), copy = Moved(Near(first, true));
  auto unmeasured = *store_->results.ResultOf(copy);
  EXPECT_TRUE(unmeasured.motion.IsZero());
  ASSERT_TRUE(store_->results.FinishAttempt(copy, unmeasured, {}).ok());
  EXPECT_TRUE(Flagged(copy)) << "a run that measured no motion says nothing";
  Finish(copy, Near(first, false));
  EXPECT_FALSE(Flagged(copy));
  EXPECT_EQ(*store_->motions.NearestTo(copy), Near(first, false));
}

TEST_P(MotionStoreTest, MotionsUnderAnAssignmentAreItsOwnAndNotTheExcused) {
  AssignmentRow row;
  row.exercise = world_.exercise.name;
  const Uuid assignment = store_->assignments.AddAssignment(row, kSystem)->id;
  const Uuid another = store_->assignments.AddAssignment(row, kSystem)->id;
  auto under = [&](const Uuid& which, const std::optional<NearAttempt>& nearest = {}) {
    const Uuid attempt = world_.ScoredUnder(which);
    Finish(attempt, nearest);
    return attempt;
  };
  const Uuid first = under(assignment), near = under(assignment, Near(first, false));
  const Uuid excused = under(assignment);
  under(another);
  ASSERT_TRUE(store_->judging.FlagAttempt(excused, kExcused, "power cut", kSystem).ok());
  const auto rows = *store_->motions.MotionsUnder(assignment, 10);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].attempt, near) << "the newest first";
  EXPECT_EQ(rows[0].record.hand, kCalm);
  EXPECT_EQ(rows[0].record.near_share, 12.0 / 1400);
  EXPECT_EQ(rows[1].attempt, first);
  EXPECT_FALSE(rows[1].record.near_share) << "there was none before it";
  EXPECT_EQ(store_->motions.MotionsUnder(assignment, 1)->size(), 1u);
}

// A reference cut and a simulated hand's work, before newer ones of people.
TEST_P(MotionStoreTest, PresetPathsComeFirstAndAreNamed) {
  const Uuid program = Moved(), person = Moved(), last = Moved();
  auto hand = [&](const Uuid& attempt, HandKind kind) {
    ASSERT_TRUE(store_->engine->rows
                    .Write([&](sql::Db& db) {
                      return Query(db,
                                   "UPDATE attempts SET hand_kind = ?3 WHERE tenant = ?1 AND id "
                                   "= ?2")
                          .Bind(attempt)
                          .Bind(static_cast<int64_t>(kind))
                          .Run();
                    })
                    .ok());
  };
  hand(program, HandKind::kProgram);
  hand(person, HandKind::kHaptic);
  EXPECT_EQ(Before(last), (std::vector{program, person}));
  EXPECT_EQ(Before(last, 1), std::vector{program});
  const auto rows = *store_->motions.MotionsBefore(last, 10);
  EXPECT_TRUE(rows[0].preset);
  EXPECT_FALSE(rows[1].preset);

  NearAttempt near = Near(person, false);
  near.preset = program, near.presets = 1, near.preset_um = 40;
  Finish(last, near);
  EXPECT_EQ(*store_->motions.NearestTo(last), near);
}

TEST_P(MotionStoreTest, ItGoesWithTheRecording) {
  const Uuid attempt = Moved();
  const Uuid run = store_->jobs.LeaseJob(1, 1000)->value().lease;
  Finish(attempt, {});
  ASSERT_TRUE(store_->jobs.FinishJob(run, true, "").ok());
  ASSERT_TRUE(store_->judging.ReleaseAttempt(attempt, kSystem).ok());
  const Sha256 content = Content(attempt);
  ASSERT_TRUE(store_->retention.SetRetention({"recordings", 30}, kSystem).ok());
  ASSERT_EQ(store_->retention.ApplyRetention(kFortyDays, false, kSystem)->recordings.size(), 1u);
  EXPECT_FALSE(store_->blobs.HasBlob(content));
  EXPECT_TRUE(Before(Moved()).empty());
}

TEST_P(MotionStoreTest, ItGoesWithThePersonAndIsNamedByNobodyThen) {
  const Uuid attempt = Moved();
  const Sha256 content = Content(attempt);
  // Somebody else's, which stays.
  const Uuid erased_student = world_.student;
  world_.student = AddPerson(*store_, "other", Role::kStudent);
  const Uuid stays = Moved(Near(attempt, true));
  ASSERT_TRUE(store_->erasures.ErasePerson(erased_student, false, kSystem).ok());
  EXPECT_FALSE(store_->blobs.HasBlob(content));
  EXPECT_TRUE(Before(stays).empty());
  EXPECT_EQ(*store_->motions.NearestTo(stays), Near(Uuid{}, true));
  EXPECT_TRUE(Flagged(stays));
}

}  // namespace
}  // namespace enamel::server
