#include "server/training/insight.h"

#include <gtest/gtest.h>

namespace enamel::server {
namespace {

StudentWork Work(double score, double time_s, std::vector<CriterionPoints> criteria = {}) {
  StudentWork out;
  out.attempts = 1;
  out.score = score;
  out.time_s = time_s;
  out.criteria = std::move(criteria);
  return out;
}

CriterionPoints Wall(double value, double points) {
  return {"wall_mesial_mm", "Mesial wall", "mm", value, points, 20, true};
}
CriterionPoints Floor(double value, double points, double max_points = 10) {
  return {"floor_mm", "Floor", "mm", value, points, max_points, max_points > 0};
}

// Quartiles of 1 to 5 and of 1 to 4 by linear interpolation, as R's quantile() gives them by
// default.
TEST(InsightTest, QuartilesLieLinearlyBetweenTheValues) {
  const Spread odd = *SpreadOf({5, 1, 4, 2, 3});
  EXPECT_EQ(odd.least, 1);
  EXPECT_EQ(odd.lower, 2);
  EXPECT_EQ(odd.median, 3);
  EXPECT_EQ(odd.upper, 4);
  EXPECT_EQ(odd.most, 5);
  const Spread even = *SpreadOf({4, 3, 2, 1});
  EXPECT_DOUBLE_EQ(even.lower, 1.75);
  EXPECT_DOUBLE_EQ(even.median, 2.5);
  EXPECT_DOUBLE_EQ(even.upper, 3.25);
  EXPECT_EQ(SpreadOf({7})->lower, 7);
  EXPECT_FALSE(SpreadOf({}).has_value());
}

TEST(InsightTest, WhoHasNotBegunAndWhoWaitsAreCountedApart) {
  StudentWork waiting;
  waiting.attempts = 2;
  waiting.time_s = 30;
  const Insight insight = InsightOf({{}, waiting, Work(95, 60), Work(100, 90), {}});
  EXPECT_EQ(insight.students, 5u);
  EXPECT_EQ(insight.not_started, 2u);
  EXPECT_EQ(insight.waiting, 1u);
  EXPECT_EQ(insight.scored, 2u);
  EXPECT_EQ(insight.times_s->count, 3u) << "who began has spent time";
  EXPECT_EQ(insight.score_tenths[9], 2u) << "100 belongs to the last tenth";
  EXPECT_FALSE(insight.commonest.has_value());
  EXPECT_EQ(InsightOf({}).students, 0u);
}

TEST(InsightTest, CommonestErrorIsWhereMostLostHalfAndThenWhereMoreWasLost) {
  const Insight walls =
      InsightOf({Work(60, 1, {Wall(0.4, 10), Floor(0, 10)}),
                 Work(50, 1, {Wall(0.5, 0), Floor(0.4, 0)}), Work(90, 1, {Wall(0, 20)})});
  ASSERT_TRUE(walls.commonest.has_value());
  EXPECT_EQ(walls.criteria[*walls.commonest].name, "wall_mesial_mm");
  EXPECT_EQ(walls.criteria[0].half_lost, 2u) << "exactly half counts";
  EXPECT_EQ(walls.criteria[0].judged, 3u);
  EXPECT_DOUBLE_EQ(walls.criteria[0].mean_points, 10);
  EXPECT_EQ(walls.criteria[0].earned, (Tenths{1, 0, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(walls.criteria[1].judged, 2u) << "one score has no floor";

  const Insight equal = InsightOf(
      {Work(60, 1, {Floor(0.4, 0), Wall(0, 20)}), Work(60, 1, {Floor(0, 10), Wall(0.5, 0)})});
  EXPECT_EQ(equal.criteria[*equal.commonest].name, "wall_mesial_mm") << "20 points against 10";
}

TEST(InsightTest, WhatWasNotJudgedIsNobodysError) {
  const Insight insight = InsightOf({Work(80, 1, {Floor(9, 0, 0)}), Work(80, 1)});
  ASSERT_EQ(insight.criteria.size(), 1u);
  EXPECT_EQ(insight.criteria[0].judged, 0u);
  EXPECT_FALSE(insight.criteria[0].values.has_value());
  EXPECT_FALSE(insight.commonest.has_value());
}

// An attempt that cut nothing has no floor: it has lost the floor's points like one that cut it
// badly.
TEST(InsightTest, WhatWasNotMadeIsLostAndHasNoValue) {
  CriterionPoints none = Floor(0, 0);
  none.judged = false;
  const Insight insight = InsightOf({Work(0, 1, {none}), Work(90, 1, {Floor(0.1, 8)})});
  EXPECT_EQ(insight.criteria[0].judged, 2u);
  EXPECT_DOUBLE_EQ(insight.criteria[0].mean_points, 4);
  EXPECT_EQ(insight.criteria[0].half_lost, 1u);
  EXPECT_EQ(insight.criteria[0].values->count, 1u);
}

// Times 1 to 8 have median 4.5 and MAD 2: with 30 in place of 8, z = 0.6745 · 25.5 / 2 = 8.6.
TEST(InsightTest, OnlyWhatIsFarFromTheClassStandsOut) {
  std::vector<StudentWork> work;
  for (int i = 1; i <= 8; ++i) work.push_back(Work(80 + i, i));
  EXPECT_TRUE(InsightOf(work).outliers.empty());
  work.back().time_s = 30;
  const Insight insight = InsightOf(work);
  ASSERT_EQ(insight.outliers.size(), 1u);
  EXPECT_EQ(insight.outliers[0].student, 7u);
  EXPECT_EQ(insight.outliers[0].what, "time_all_attempts_s");
  EXPECT_NEAR(insight.outliers[0].z, 8.6, 0.01);
  work.erase(work.begin());
  EXPECT_TRUE(InsightOf(work).outliers.empty()) << "seven are too few";
}

// Eight of nine have 70 and one has 10: the MAD is 0, the mean of |x - 70| is 60 / 9, and
// z = -60 / (1.2533 · 60 / 9) = -7.18.
TEST(InsightTest, WhoIsFarFromAValueThatMostShareStandsOut) {
  std::vector<StudentWork> work(9, Work(70, 60));
  EXPECT_TRUE(InsightOf(work).outliers.empty()) << "all are equal";
  work[0].score = 10;
  const Insight insight = InsightOf(work);
  ASSERT_EQ(insight.outliers.size(), 1u);
  EXPECT_EQ(insight.outliers[0].student, 0u);
  EXPECT_EQ(insight.outliers[0].what, "score");
  EXPECT_NEAR(insight.outliers[0].z, -7.18, 0.01);
  for (int i = 1; i < 4; ++i) work[static_cast<size_t>(i)].score = 10;
  EXPECT_TRUE(InsightOf(work).outliers.empty()) << "four of nine are a second group";
}

TEST(InsightTest, GatesAreCountedThatTookPoints) {
  std::vector<StudentWork> work(9, Work(70, 60));
  work[3].gates = {{"task_done_percent", "Task done", 0.4}};
  work[4].gates = {{"task_done_percent", "Task done", 1}};
  const Insight insight = InsightOf(work);
  ASSERT_EQ(insight.gates.size(), 1u);
  EXPECT_EQ(insight.gates[0].taken, 1u);
}

}  // namespace
}  // namespace enamel::server
