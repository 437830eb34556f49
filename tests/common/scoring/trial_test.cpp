#include "common/scoring/trial.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/base/sha256.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

using Names = std::vector<std::string>;

Names NamesOf(const std::vector<Trial::Item>& items) {
  Names out;
  for (const Trial::Item& item : items) out.push_back(item.metric);
  return out;
}

// Points for the box's depth and for a calm hand, and no gate.
scene::Exercise Judged() {
  scene::Exercise out = BlockExercise();
  out.rubric.name = "box";
  out.rubric.criteria = {{"floor_mm", "Floor", "mm", 60, {{-0.5, 0}, {0, 1}, {0.5, 0}}, "", {}},
                         {"force_sent_max_n", "Force", "N", 40, {{2, 1}, {8, 0}}, "", {}}};
  return out;
}

class TrialTest : public ::testing::Test {
 protected:
  Trial Try(const scene::Exercise& exercise) const {
    auto trial = TryExercise(BlockScene(), exercise, block_);
    EXPECT_TRUE(trial.ok()) << trial.status().message();
    return trial.ok() ? std::move(*trial) : Trial{};
  }

  const cutting::Volume block_ = MakeBlock(100'000);
  scene::Exercise exercise_ = Judged();
};

TEST_F(TrialTest, TheExactCutGetsFullMarks) {
  const Trial trial = Try(exercise_);
  EXPECT_DOUBLE_EQ(trial.exact.score, 100);
  EXPECT_EQ(NamesOf(trial.lost_by_exact), Names{});
}

TEST_F(TrialTest, NamesWhatTheExactCutLoses) {
  exercise_.rubric.criteria[0].map = {{0, 0}, {0.5, 1}};  // asks for a floor that is too deep
  const Trial trial = Try(exercise_);
  EXPECT_DOUBLE_EQ(trial.exact.score, 40);
  ASSERT_EQ(NamesOf(trial.lost_by_exact), Names{"floor_mm"});
  EXPECT_EQ(trial.lost_by_exact[0].title, "Floor");
  EXPECT_DOUBLE_EQ(trial.lost_by_exact[0].share, 0);
}

TEST_F(TrialTest, NamesWhatAnUntouchedToothGetsInFull) {
  const Trial trial = Try(exercise_);
  EXPECT_EQ(NamesOf(trial.full_untouched), Names{"force_sent_max_n"});
  exercise_.rubric.gates = {{"task_done_percent", "Task", "%", {{0, 0}, {90, 1}}, ""}};
  EXPECT_EQ(NamesOf(Try(exercise_).full_untouched), Names{}) << "nothing is left after the gate";
}

TEST_F(TrialTest, DoesNotAskForWhatOnlyAHandCanShow) {
  exercise_.rubric.criteria.push_back(
      {"angulation_p95_deg", "Angle of the bur", "deg", 50, {{10, 1}, {30, 0}}, "", {}});
  const Trial trial = Try(exercise_);
  EXPECT_DOUBLE_EQ(trial.exact.score, 100);
  EXPECT_EQ(NamesOf(trial.lost_by_exact), Names{});
}

TEST_F(TrialTest, ReportsACriticalErrorOfTheExactCut) {
  exercise_.rubric.critical = {{"pulp_exposed", "floor_mm", "mm", -0.1, true, ""}};
  const Trial trial = Try(exercise_);
  EXPECT_TRUE(trial.exact.critical_fail);
  ASSERT_EQ(trial.exact.critical.size(), 1u);
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

// A box that reaches the neighbour: the exact cut leaves that alone.
TEST(BuiltinTrialTest, AClassTwoIsRight) {
  const auto built = scene::BuildBuiltinScene("molar-class-2", 200'000);
  ASSERT_TRUE(built.ok());
  for (const scene::Exercise& exercise :
       scene::BuiltinExercises(built->scene, HashSha256(AsBytes(scene::ToJson(built->scene))))) {
    if (exercise.name.find("class-2") == std::string::npos) continue;
    const auto trial = TryExercise(built->scene, exercise, built->volume);
    ASSERT_TRUE(trial.ok()) << trial.status().message();
    EXPECT_DOUBLE_EQ(trial->exact.score, 100);
    EXPECT_DOUBLE_EQ(trial->untouched.score, 0);
    EXPECT_EQ(NamesOf(trial->lost_by_exact), Names{});
    EXPECT_EQ(NamesOf(trial->full_untouched), Names{});
    return;
  }
  FAIL() << "the molar has no class 2";
}

}  // namespace
}  // namespace enamel::scoring
