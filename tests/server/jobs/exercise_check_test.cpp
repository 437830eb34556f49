#include "server/jobs/exercise_check.h"

#include <gtest/gtest.h>

#include <functional>

#include "common/cutting/voxel_limit.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"
#include "server/jobs/rubric_check.h"
#include "tests/server/storage/store_world.h"

// Exercises that nobody can do, or that cannot be judged, are refused with the expected and found
// value.
namespace enamel::server {
namespace {

const scene::RubricCriterion kTime{"time_s", "Time", "s", 10, {{300, 1}, {600, 0}}, "slow", {}};
const scene::RubricCriterion kForce{"force_sent_p95_n", "Force", "N", 10,
                                    {{1, 1}, {3, 0}},   "hard",  {}};

class ExerciseCheckTest : public ::testing::Test {
 protected:
  // Coarse, and so practice: the checks are about sizes of millimetres.
  static constexpr int32_t kVoxel_nm = 300'000;

  std::vector<scene::Exercise> ExercisesOf(const std::string& name) {
    auto built = scene::BuildBuiltinScene(name, kVoxel_nm);
    EXPECT_TRUE(built.ok()) << name;
    // At the voxel of teeth that a server makes, no bur is left to warn of.
    for (const scene::BurSpec& bur : built->scene.burs)
      EXPECT_FALSE(cutting::WhyTooCoarse(bur.metric(), 50'000, true)) << bur.name;
    EXPECT_TRUE(store_->blobs.PutBlob(scene::EncodeVolume(built->volume)).ok());
    const auto content = store_->blobs.PutBlob(AsBytes(scene::ToJson(built->scene)));
    auto exercises = scene::BuiltinExercises(built->scene, *content);
    for (scene::Exercise& exercise : exercises) exercise.graded = false;
    return exercises;
  }
  scene::Exercise Named(const std::string& scene, const std::string& kind) {
    for (scene::Exercise& exercise : ExercisesOf(scene)) {
      if (exercise.name.starts_with(kind)) return exercise;
    }
    ADD_FAILURE() << scene << " " << kind;
    return {};
  }
  void ExpectRefused(const scene::Exercise& good,
                     const std::function<void(scene::Exercise&)>& change,
                     const std::string& field) {
    scene::Exercise bad = good;
    change(bad);
    const Status refused = CheckExercise(store_->blobs, bad);
    EXPECT_EQ(refused.code(), Code::kInvalidInput) << field;
    EXPECT_EQ(refused.field(), field) << refused.message();
    EXPECT_NE(refused.message().find("found"), std::string::npos) << refused.message();
  }

  test::TempFolder folder_;
  std::unique_ptr<Store> store_ = server::testing::OpenStore(folder_.path());
};

TEST_F(ExerciseCheckTest, EveryBuiltInExerciseCanBeDoneAndSaysTheSizesOfItsTarget) {
  for (const std::string& name : scene::BuiltinSceneNames()) {
    for (const scene::Exercise& exercise : ExercisesOf(name)) {
      const Status status = CheckExercise(store_->blobs, exercise);
      EXPECT_TRUE(status.ok()) << exercise.name << ": " << status.field() << " "
                               << status.message();
      for (const std::string& warning : ExerciseWarnings(store_->blobs, exercise))
        EXPECT_NE(warning.find("too coarse"), std::string::npos) << exercise.name << warning;
      EXPECT_TRUE(RepeatedMetrics(exercise.rubric).empty()) << exercise.name;
    }
  }
}

TEST_F(ExerciseCheckTest, WhatNobodyCanDoIsRefused) {
  const scene::Exercise good = Named("molar", "class-1");
  ASSERT_TRUE(CheckExercise(store_->blobs, good).ok());
  ExpectRefused(
      good, [](auto& e) { e.target.landmark = "nowhere"; }, "target.landmark");
  ExpectRefused(
      good, [](auto& e) { e.time_limit_s = 3; }, "time_limit_s");
  ExpectRefused(
      good, [](auto& e) { e.target.half_size_um[1] = e.bur_radius_um - 50; }, "bur.radius_um");
  ExpectRefused(
      good, [](auto& e) { e.target.half_size_um[0] = 15'000; }, "target.half_size_um");
  ExpectRefused(
      good, [](auto& e) { e.target.depth_um = 6'000; }, "target.depth_um");
}

TEST_F(ExerciseCheckTest, GradedWorkInVoxelsTooCoarseForItsBurIsRefusedAndPracticeIsWarned) {
  scene::Exercise exercise = Named("molar", "class-1");
  EXPECT_TRUE(CheckExercise(store_->blobs, exercise).ok());
  const auto warnings = ExerciseWarnings(store_->blobs, exercise);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("voxels of 300 um are too coarse for the bur (cylinder r 0.5 x 4 mm)"),
            std::string::npos)
      << warnings[0];
  exercise.graded = true;
  for (const bool prepared : {false, true}) {
    if (prepared) exercise.target.prepared = HashSha256(AsBytes("a prepared tooth"));
    const Status refused = CheckExercise(store_->blobs, exercise);
    EXPECT_EQ(refused.code(), Code::kInvalidInput);
    EXPECT_EQ(refused.field(), "bur.radius_um");
    EXPECT_NE(refused.message().find("Use voxels of 186 um or less"), std::string::npos)
        << refused.message();
  }
  exercise.bur_radius_um = 800;
  exercise.bur_length_um = 8000;
  exercise.target.prepared = {};
  EXPECT_TRUE(CheckExercise(store_->blobs, exercise).ok());
}

TEST_F(ExerciseCheckTest, CriticalErrorOfWhatTheToothDoesNotHaveIsRefused) {
  const scene::Exercise good = Named("molar", "class-1");
  // It would never be found.
  auto critical = [](const char* error, const char* metric, const char* unit) {
    return
        [=](scene::Exercise& e) { e.rubric.critical[0] = {error, metric, unit, 25, true, "us"}; };
  };
  const std::string listed = "rubric.critical[0].metric";
  ExpectRefused(good, critical("neighbour_damaged", "neighbour_depth_mm", "mm"), listed);
  ExpectRefused(good, critical("contact_left", "contact_left_percent", "%"), listed);
  ExpectRefused(good, critical("caries_left_deep", "caries_left_percent", "%"), listed);
  ExpectRefused(good, critical("cannot_seat", "crown_overhang_mm", "mm"), listed);
}

TEST_F(ExerciseCheckTest, RubricThatCannotJudgeTheTargetIsRefused) {
  auto without = [](const char* kind) {
    return [=](scene::Exercise& e) {
      std::erase_if(e.rubric.prices, [=](const auto& price) { return price.of == kind; });
    };
  };
  const scene::Exercise cavity = Named("molar", "class-1");
  for (const char* kind : {"wall", "floor", "line_angle"})
    ExpectRefused(cavity, without(kind), "rubric.prices");
  const scene::Exercise crown = Named("molar", "crown");
  for (const char* kind : {"table", "axial_wall", "margin"})
    ExpectRefused(crown, without(kind), "rubric.prices");
}

TEST_F(ExerciseCheckTest, WordsThatATerminalObeysAreRefused) {
  scene::Exercise good = Named("molar", "class-1");
  good.rubric.criteria = {kTime, kForce};
  ASSERT_TRUE(CheckExercise(store_->blobs, good).ok());
  for (const std::string bad : {"a\x1b[2J", "a\nb",
                                "a\xe2\x80\xae"
                                "b"}) {
    ExpectRefused(
        good, [&](auto& e) { e.rubric.prices[1].source = bad; }, "rubric.prices[1].source");
    ExpectRefused(
        good, [&](auto& e) { e.rubric.criteria[0].title = bad; }, "rubric.criteria[0].title");
    ExpectRefused(
        good, [&](auto& e) { e.rubric.criteria[1].comment = bad; }, "rubric.criteria[1].comment");
  }
}

TEST_F(ExerciseCheckTest, SizesAndMetricsThatContradictAreWarnedAbout) {
  scene::Exercise exercise = Named("molar", "class-1");
  exercise.instructions = "Cut it 7.5 mm deep.";
  const auto warnings = ExerciseWarnings(store_->blobs, exercise);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("7.5 mm deep"), std::string::npos);
  exercise.rubric.criteria = {kTime, kForce, kTime};
  ASSERT_EQ(RepeatedMetrics(exercise.rubric).size(), 1u);
}

}  // namespace
}  // namespace enamel::server
