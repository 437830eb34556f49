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

TEST(CriticalTest, WithinTwoUncertaintiesOfItsLimitAnErrorIsBorderlineAndNotCritical) {
  auto scored = [](double wall) {
    MetricSet metrics = Values(wall);
    metrics.values[0].uncertainty = 0.02;
    return *ApplyRubric(WithCritical(), metrics, {{"wall_mesial", "wall", 0, 0.2}});
  };
  for (const double wall : {-0.17, -0.2, -0.239}) {
    const ScoreResult r = scored(wall);
    EXPECT_FALSE(r.critical_fail) << wall;
    ASSERT_EQ(r.borderline.size(), 1U) << wall;
    EXPECT_EQ(r.borderline[0].error, "contact_left");
    EXPECT_EQ(r.borderline[0].uncertainty, 0.02);
    EXPECT_EQ(r.score, r.points);
  }
  EXPECT_TRUE(scored(-0.241).critical_fail);
  EXPECT_TRUE(scored(-0.241).borderline.empty());
  EXPECT_TRUE(scored(-0.159).borderline.empty());
  // No pulp is in sight, and none may be.
  EXPECT_FALSE(IsBorderline(0, 0, 0.1));
  EXPECT_TRUE(IsBorderline(0.1, 0, 0.1));
}

TEST(CriticalTest, PointsNearTheLeastThatPassAreBorderlineWhereTheyAloneDecide) {
  Rubric rubric = WithCritical();
  rubric.prices = {{"wall", 0.5, 0.5, 50, 500, 2, 90, "a test"}};
  auto scored = [&](double left_mm, double uncertainty_mm) {
    return *ApplyRubric(rubric, Values(0), {{"wall_mesial", "wall", 0, left_mm, uncertainty_mm}});
  };
  const ScoreResult near = scored(0.51, 0.01);
  // A size of 0.5 mm costs 50 points: 100 of a millimetre, a little less at the curve's bend.
  EXPECT_NEAR(near.points_uncertainty, 1, 0.02);
  ASSERT_EQ(near.borderline.size(), 1U);
  EXPECT_EQ(near.borderline[0].error, kPassLimit);
  EXPECT_TRUE(scored(0.51, 0.001).borderline.empty());
  EXPECT_TRUE(scored(0.6, 0.01).borderline.empty());
  rubric.prices[0].redo_points = 20;
  EXPECT_TRUE(scored(0.51, 0.01).borderline.empty());
}

TEST(CriticalTest, OneThatTheExerciseCannotShowIsRefusedWithTheReason) {
  const Rubric rubric = WithCritical();
  MetricSet metrics = Values(0);
  EXPECT_TRUE(CheckCriticalIsMeasured(rubric, metrics).ok());
  metrics.values.erase(metrics.values.begin());
  EXPECT_FALSE(FindCritical(rubric, metrics).ok());
  metrics.missing = {{"wall_mesial_mm", NoValue::kNotMade}};
  EXPECT_TRUE(CheckCriticalIsMeasured(rubric, metrics).ok());
  EXPECT_TRUE(FindCritical(rubric, metrics)->critical.empty());
  metrics.missing[0].why = NoValue::kNotInTask;
  const Status refused = CheckCriticalIsMeasured(rubric, metrics);
  EXPECT_EQ(refused.field(), "critical[0].metric");
  EXPECT_NE(refused.message().find("contact_left could never be found"), std::string::npos);
}

}  // namespace
}  // namespace enamel::scoring
