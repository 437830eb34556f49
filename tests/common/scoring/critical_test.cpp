#include "common/scoring/critical.h"

#include <gtest/gtest.h>

#include "common/scoring/score.h"

namespace enamel::scoring {
namespace {

using scene::Rubric;

Rubric WithCritical() {
  Rubric rubric;
  rubric.name = "class-1";
  rubric.prices = {{"wall", 0.5, 0.5, 10, 30, 2, 10, "a test"}};
  rubric.critical = {{"contact_left", "wall_mesial_mm", "mm", -0.2, false, "a textbook"}};
  return rubric;
}
MetricSet Values(double wall) { return {{{"wall_mesial_mm", wall, "mm"}}, {}}; }
ScoreResult Score(double wall, double left_mm) {
  return *ApplyRubric(WithCritical(), Values(wall), {{"wall_mesial", "wall", 0, left_mm}});
}

TEST(CriticalTest, IsNotAcceptableAndThePointsWithoutItAreBesideIt) {
  const ScoreResult at_limit = Score(-0.2, 0.2);
  EXPECT_FALSE(at_limit.critical_fail);
  EXPECT_EQ(at_limit.acceptance, Acceptance::kWithRemarks);
  EXPECT_EQ(at_limit.score, at_limit.points);
  const ScoreResult beyond = Score(-0.201, 0.2);
  EXPECT_TRUE(beyond.critical_fail);
  EXPECT_EQ(beyond.acceptance, Acceptance::kNotAcceptable);
  EXPECT_EQ(beyond.score, 0);
  EXPECT_EQ(beyond.points, at_limit.points);
  ASSERT_EQ(beyond.critical.size(), 1U);
  EXPECT_EQ(beyond.critical[0].reason,
            "The contact with the adjacent tooth is not broken (-0.201 mm, at least -0.20 mm).");
  EXPECT_EQ(Score(0, 0).acceptance, Acceptance::kAcceptable);
}

TEST(CriticalTest, OneThatTheExerciseCannotShowIsRefusedWithTheReason) {
  const Rubric rubric = WithCritical();
  MetricSet metrics = Values(0);
  EXPECT_TRUE(CheckCriticalIsMeasured(rubric, metrics).ok());
  metrics.values.erase(metrics.values.begin());
  EXPECT_FALSE(FindCritical(rubric, metrics).ok());
  metrics.missing = {{"wall_mesial_mm", NoValue::kNotMade}};
  EXPECT_TRUE(CheckCriticalIsMeasured(rubric, metrics).ok());
  EXPECT_TRUE(FindCritical(rubric, metrics)->empty());
  metrics.missing[0].why = NoValue::kNotInTask;
  const Status refused = CheckCriticalIsMeasured(rubric, metrics);
  EXPECT_EQ(refused.field(), "critical[0].metric");
  EXPECT_NE(refused.message().find("contact_left could never be found"), std::string::npos);
}

}  // namespace
}  // namespace enamel::scoring
