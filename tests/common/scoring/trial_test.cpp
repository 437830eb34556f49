#include "common/scoring/trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <string>

#include "common/scene/builtin/builtin.h"
#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

// Of what is left of a task, which is summed in another order than the task.
constexpr double kRounding = 1e-6;

// Prices of a box and a calm hand, whatever the built-in ones are.
scene::Exercise Judged() {
  scene::Exercise out = BlockExercise();
  out.rubric.name = "box";
  out.rubric.prices = {{"floor", 0.45, 0.6, 14, 42, 2, 14, "a test"},
                       {"wall", 0.45, 0.6, 12, 36, 2, 12, "a test"},
                       {"line_angle", 0.6, 0.6, 5, 6, 1, 5, "a test"}};
  out.rubric.criteria = {{"force_sent_max_n", "Force", "N", 40, {{2, 1}, {8, 0}}, "", {}}};
  return out;
}

class TrialTest : public ::testing::Test {
 protected:
  Trial Try(const scene::Exercise& exercise) const {
    auto trial = TryExercise(BlockScene(), exercise, block_);
    EXPECT_TRUE(trial.ok()) << trial.status().message();
    return trial.ok() ? std::move(*trial) : Trial{};
  }

  const cutting::Volume block_ = MakeBlock(200'000);
  scene::Exercise exercise_ = Judged();
};

TEST_F(TrialTest, TheExactCutCostsNothingAndAnUntouchedToothEverything) {
  const Trial trial = Try(exercise_);
  EXPECT_EQ(trial.exact.score, 100);
  EXPECT_EQ(LostItems(trial.exact), std::vector<LostItem>{});
  EXPECT_TRUE(trial.exact.mistakes.empty());
  EXPECT_NEAR(trial.untouched.score, 0, kRounding);
  EXPECT_FALSE(trial.untouched.mistakes.empty());
  for (const ScoreResult* score : {&trial.exact, &trial.untouched})
    EXPECT_EQ(BrokenLaw(*score), "");
}

TEST_F(TrialTest, WhatCostsPointsIsListedTheDearestFirst) {
  const std::vector<LostItem> lost = LostItems(Try(exercise_).untouched);
  ASSERT_FALSE(lost.empty());
  EXPECT_TRUE(std::ranges::is_sorted(lost, std::greater<>(), &LostItem::points));
  for (const char* region : {"floor", "wall_mesial", "wall_distal", "wall_buccal", "wall_lingual"})
    EXPECT_EQ(std::ranges::count(lost, region, &LostItem::name), 1) << region;
  double sum = 0;
  for (const LostItem& item : lost) sum += item.points;
  EXPECT_GE(sum, 100 - 1e-9);
}

TEST_F(TrialTest, AKindOfRegionWithoutAPriceIsRefused) {
  exercise_.rubric.prices.erase(exercise_.rubric.prices.begin());
  const auto trial = TryExercise(BlockScene(), exercise_, block_);
  EXPECT_EQ(trial.status().field(), "prices");
  EXPECT_NE(trial.status().message().find("floor"), std::string::npos);
}

TEST_F(TrialTest, DoesNotAskForWhatOnlyAHandCanShow) {
  exercise_.rubric.criteria.push_back(
      {"angulation_p95_deg", "Angle of the bur", "deg", 50, {{10, 1}, {30, 0}}, "", {}});
  const Trial trial = Try(exercise_);
  EXPECT_EQ(trial.exact.score, 100);
  EXPECT_EQ(LostItems(trial.exact), std::vector<LostItem>{});
  EXPECT_FALSE(trial.exact.criteria.back().judged);
}

TEST_F(TrialTest, NamesTheHandsFigureThatACalmRecordingDoesNotMeet) {
  exercise_.rubric.criteria[0].map = {{0, 1}, {0.5, 0}};  // asks for less than its newton
  const Trial trial = Try(exercise_);
  EXPECT_EQ(trial.exact.score, 60);
  EXPECT_EQ(LostItems(trial.exact), (std::vector<LostItem>{{"force_sent_max_n", 40}}));
}

TEST_F(TrialTest, ReportsACriticalErrorOfTheExactCut) {
  exercise_.rubric.critical = {{"pulp_exposed", "floor_mm", "mm", -0.1, true, ""}};
  const Trial trial = Try(exercise_);
  EXPECT_TRUE(trial.exact.critical_fail);
  ASSERT_EQ(trial.exact.critical.size(), 1U);
}

TEST_F(TrialTest, EndsWhenItIsToldWhereverItIs) {
  std::vector<double> shares;
  auto run = [&](size_t most) {
    shares.clear();
    return TryExercise(BlockScene(), exercise_, block_, [&](double share) {
      shares.push_back(share);
      return shares.size() < most;
    });
  };
  ASSERT_TRUE(run(100).ok());
  const size_t steps = shares.size();
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_DOUBLE_EQ(shares.back(), 1);
  for (size_t most = 1; most <= steps; ++most) {
    EXPECT_EQ(run(most).status().code(), Code::kUnavailable) << most;
    EXPECT_EQ(shares.size(), most);
  }
}

// Every built-in exercise prices each kind of region that its exact target shows, that target costs nothing, and nobody
// earns points for an untouched tooth.
class BuiltinTrialTest : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Scenes, BuiltinTrialTest, testing::ValuesIn(scene::BuiltinSceneNames()),
                         [](const auto& scene) {
                           std::string name = scene.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST_P(BuiltinTrialTest, ItsRubricsAreRightForTheExactCutAndTheUntouchedTooth) {
  if (GetParam() != "molar" && GetParam() != "block" && std::getenv("ENAMEL_FULL") == nullptr)
    GTEST_SKIP() << "takes long: ./check --full";
  const auto built = scene::BuildBuiltinScene(GetParam(), 200'000);
  ASSERT_TRUE(built.ok()) << built.status().message();
  for (const scene::Exercise& exercise : scene::BuiltinExercises(built->scene, {})) {
    SCOPED_TRACE(exercise.name);
    EXPECT_TRUE(ValidateRubric(exercise.rubric).ok());
    const auto trial = TryExercise(built->scene, exercise, built->volume);
    ASSERT_TRUE(trial.ok()) << trial.status().message();
    EXPECT_EQ(trial->exact.score, 100);
    EXPECT_FALSE(trial->exact.critical_fail);
    EXPECT_EQ(LostItems(trial->exact), std::vector<LostItem>{});
    EXPECT_EQ(trial->untouched.score, 0);
    EXPECT_TRUE(trial->untouched.critical_fail);
    // Also without its critical error; caries has a price of its own and is no part of what was not done.
    if (std::ranges::count(trial->untouched.measures, whole::kCaries, &RegionMeasure::kind) == 0) {
      EXPECT_NEAR(trial->untouched.points, 0, kRounding);
    }
    EXPECT_EQ(BrokenLaw(trial->exact), "");
    EXPECT_EQ(BrokenLaw(trial->untouched), "");
    size_t regions = 0;
    for (const RegionMeasure& measure : trial->exact.measures) {
      if (measure.kind == whole::kNotDone) continue;
      const auto prices =
          std::ranges::count(exercise.rubric.prices, measure.kind, &scene::RubricPrice::of);
      // Caries in a task that is not there for it costs nothing.
      if (measure.kind != whole::kCaries) {
        EXPECT_EQ(prices, 1) << measure.name;
      }
      regions += UnitOf(measure.kind) == "mm" && measure.kind != whole::kNeighbour;
    }
    EXPECT_GT(regions, 0U);
  }
}

}  // namespace
}  // namespace enamel::scoring
