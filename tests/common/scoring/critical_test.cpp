#include "common/scoring/critical.h"

#include <gtest/gtest.h>

#include "common/scoring/score.h"

namespace enamel::scoring {
namespace {

using scene::Rubric;

scene::RubricCritical ShortWall() {
  return {"contact_left", "wall_mesial_mm", "mm", -0.2, false, "a textbook"};
}
Rubric WithCritical() {
  Rubric rubric{"class-1", 3, {}, {}};
  rubric.criteria.push_back({"wall_mesial_mm",
                             "Mesial wall",
                             "mm",
                             60,
                             {{-0.3, 0}, {-0.05, 1}, {0.05, 1}, {0.3, 0}},
                             "Watch the line angle.",
                             {}});
  rubric.critical = {ShortWall()};
  return rubric;
}
MetricSet Values(double wall) { return {{{"wall_mesial_mm", wall, "mm"}}, {}}; }

TEST(CriticalTest, IsNotAcceptableAndThePointsWithoutItAreBesideIt) {
  const Rubric rubric = WithCritical();
  const ScoreResult at_limit = *ApplyRubric(rubric, Values(-0.2));
  EXPECT_FALSE(at_limit.critical_fail);
  EXPECT_EQ(at_limit.acceptance, Acceptance::kWithRemarks);
  EXPECT_EQ(at_limit.score, at_limit.points);
  const ScoreResult beyond = *ApplyRubric(rubric, Values(-0.201));
  EXPECT_TRUE(beyond.critical_fail);
  EXPECT_EQ(beyond.acceptance, Acceptance::kNotAcceptable);
  EXPECT_EQ(beyond.score, 0);
  EXPECT_NEAR(beyond.points, at_limit.points, 1);
  ASSERT_EQ(beyond.critical.size(), 1U);
  EXPECT_EQ(beyond.critical[0].reason,
            "The contact with the adjacent tooth is not broken (-0.201 mm, at least -0.20 mm).");
  EXPECT_EQ(ApplyRubric(rubric, Values(0))->acceptance, Acceptance::kAcceptable);
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
