#include "server/jobs/exercise_trial.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"
#include "tests/server/storage/store_world.h"

namespace enamel::server {
namespace {

using State = ExerciseTrials::State;

class ExerciseTrialsTest : public ::testing::Test {
 protected:
  ExerciseTrialsTest() {
    const auto built = scene::BuildBuiltinScene("block", 300'000);
    EXPECT_TRUE(store_->blobs.PutBlob(scene::EncodeVolume(built->volume)).ok());
    const auto content = store_->blobs.PutBlob(AsBytes(scene::ToJson(built->scene)));
    exercise_ = scene::ClassOneExercise(built->scene, *content);
  }

  ExerciseTrials::About Ended(const Uuid& person, const Uuid& id) {
    for (;;) {
      const auto about = trials_->Get(person, id);
      if (!about.ok()) return {};
      if (about->state == State::kDone || about->state == State::kFailed) return *about;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  test::TempFolder folder_;
  std::unique_ptr<Store> store_ = server::testing::OpenStore(folder_.path());
  scene::Exercise exercise_;
  std::optional<ExerciseTrials> trials_{std::in_place, store_->blobs};
  const Uuid ada_ = Uuid::New(), ben_ = Uuid::New();
};

TEST_F(ExerciseTrialsTest, ATrialEndsWithBothScores) {
  const auto begun = trials_->Begin(ada_, exercise_);
  ASSERT_TRUE(begun.ok());
  const auto ended = Ended(ada_, begun->id);
  ASSERT_EQ(ended.state, State::kDone) << ended.problem.message();
  EXPECT_DOUBLE_EQ(ended.trial->exact.score, 100);
  EXPECT_DOUBLE_EQ(ended.trial->untouched.score, 0);
  EXPECT_GT(ended.took_s, 0);
}

TEST_F(ExerciseTrialsTest, WhatCannotBeTriedFailsWithTheReason) {
  exercise_.target.landmark = "nowhere";
  const auto ended = Ended(ada_, trials_->Begin(ada_, exercise_)->id);
  EXPECT_EQ(ended.state, State::kFailed);
  EXPECT_EQ(ended.problem.field(), "target.landmark");
}

TEST_F(ExerciseTrialsTest, IsItsPersonsAloneAndGoesWhenTheNextBegins) {
  const auto first = trials_->Begin(ada_, exercise_);
  EXPECT_EQ(trials_->Get(ben_, first->id).status().code(), Code::kNotFound);
  EXPECT_EQ(trials_->GiveUp(ben_, first->id).code(), Code::kNotFound);
  const auto second = trials_->Begin(ada_, exercise_);
  EXPECT_EQ(trials_->Get(ada_, first->id).status().code(), Code::kNotFound);
  EXPECT_EQ(Ended(ada_, second->id).state, State::kDone);
  EXPECT_TRUE(trials_->GiveUp(ada_, second->id).ok());
  EXPECT_EQ(trials_->Get(ada_, second->id).status().code(), Code::kNotFound);
}

TEST_F(ExerciseTrialsTest, ComeInOrderAndOnlySoManyWait) {
  std::vector<std::pair<Uuid, Uuid>> begun;  // person, trial
  // One may run meanwhile.
  for (size_t i = 0; i <= ExerciseTrials::kMaxWaiting; ++i) {
    const Uuid person = Uuid::New();
    const auto about = trials_->Begin(person, exercise_);
    if (!about.ok()) break;
    EXPECT_LE(about->ahead, i);
    begun.push_back({person, about->id});
  }
  EXPECT_GE(begun.size(), ExerciseTrials::kMaxWaiting);
  Status refused;
  for (int i = 0; i < 3 && refused.ok(); ++i)
    refused = trials_->Begin(Uuid::New(), exercise_).status();
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_EQ(Ended(begun[1].first, begun[1].second).state, State::kDone);
  EXPECT_EQ(trials_->Get(begun[0].first, begun[0].second)->state, State::kDone);
  for (size_t i = 2; i < begun.size(); ++i)
    EXPECT_TRUE(trials_->GiveUp(begun[i].first, begun[i].second).ok());
  EXPECT_EQ(Ended(ada_, trials_->Begin(ada_, exercise_)->id).state, State::kDone);
}

TEST_F(ExerciseTrialsTest, ServerThatStopsEndsWhatRuns) {
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(trials_->Begin(Uuid::New(), exercise_).ok());
  trials_.reset();  // returns
}

}  // namespace
}  // namespace enamel::server
