#include "server/training/insight.h"

#include <gtest/gtest.h>

namespace enamel::server {
namespace {

StudentWork Work(double score, double time_s, std::vector<CriterionLost> criteria = {},
                 std::vector<MistakeMade> mistakes = {}) {
  StudentWork out;
  out.attempts = 1;
  out.score = score;
  out.time_s = time_s;
  out.criteria = std::move(criteria);
  out.mistakes = std::move(mistakes);
  return out;
}

CriterionLost Outline(double lost, bool to_change = false) {
  return {"outline", "outline", "Outline", "", lost, to_change, true, std::nullopt};
}
CriterionLost Force(double value, double lost) {
  return {"force_sent_p95_n", "hand", "Light hand", "N", lost, false, true, value};
}
MistakeMade Over(const std::string& place, double points, double size_mm) {
  return {"over_extended", place, "outline", "mm", points, size_mm, {10 * size_mm, 0, 1}};
}
StudentWork Made(std::vector<MistakeMade> mistakes) { return Work(80, 1, {}, std::move(mistakes)); }

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

TEST(InsightTest, ACriterionSaysWhatTheClassLostThereAndWhoHasToChangeIt) {
  const Insight insight = InsightOf({Work(88, 1, {Outline(12, true), Force(1.5, 2)}),
                                     Work(98, 1, {Outline(2)}), Work(96, 1, {Outline(4)})});
  ASSERT_EQ(insight.criteria.size(), 2u);
  const CriterionInsight &outline = insight.criteria[0], &force = insight.criteria[1];
  EXPECT_EQ(outline.name, "outline");
  EXPECT_EQ(outline.judged, 3u);
  EXPECT_EQ(outline.to_change, 1u);
  EXPECT_DOUBLE_EQ(outline.mean_lost, 6);
  EXPECT_EQ(outline.lost->median, 4);
  EXPECT_FALSE(outline.values.has_value()) << "a group has no figure";
  EXPECT_EQ(force.judged, 1u) << "two scores have no force";
  EXPECT_EQ(force.values->median, 1.5);
}

TEST(InsightTest, WhatWasNotJudgedIsNobodysLoss) {
  CriterionLost none = Force(9, 0);
  none.judged = false;
  const Insight insight = InsightOf({Work(80, 1, {none}), Work(80, 1)});
  ASSERT_EQ(insight.criteria.size(), 1u);
  EXPECT_EQ(insight.criteria[0].judged, 0u);
  EXPECT_FALSE(insight.criteria[0].values.has_value());
  EXPECT_FALSE(insight.criteria[0].lost.has_value());
}

TEST(InsightTest, MistakesOfOneKindAtOnePlaceAreOneRowTheDearestFirst) {
  const Insight insight =
      InsightOf({Made({Over("wall_mesial", 3, 0.2), Over("wall_distal", 1, 0.1)}),
                 Made({Over("wall_mesial", 5, 0.4)}), Made({Over("wall_mesial", 7, 0.9)})});
  ASSERT_EQ(insight.mistakes.size(), 2u);
  const MistakeInsight& mesial = insight.mistakes[0];
  EXPECT_EQ(mesial.kind, "over_extended");
  EXPECT_EQ(mesial.place, "wall_mesial");
  EXPECT_EQ(mesial.group, "outline");
  EXPECT_EQ(mesial.unit, "mm");
  EXPECT_EQ(mesial.students, 3u);
  EXPECT_DOUBLE_EQ(mesial.points, 15);
  EXPECT_DOUBLE_EQ(mesial.size, 0.4) << "the median";
  EXPECT_DOUBLE_EQ(mesial.at_mm[0], 5) << "the middle of 2, 4 and 9";
  EXPECT_EQ(insight.mistakes[1].place, "wall_distal");
}

TEST(InsightTest, AStudentWhoMadeAMistakeTwiceAtOnePlaceCountsOnce) {
  const Insight insight =
      InsightOf({Made({Over("wall_mesial", 1, 0.1), Over("wall_mesial", 2, 0.3)})});
  ASSERT_EQ(insight.mistakes.size(), 1u);
  EXPECT_EQ(insight.mistakes[0].students, 1u);
  EXPECT_DOUBLE_EQ(insight.mistakes[0].points, 3);
  EXPECT_DOUBLE_EQ(insight.mistakes[0].size, 0.3) << "that of the dearer";
}

TEST(InsightTest, AMistakeThatCostsAStudentNextToNothingIsNotCounted) {
  const double below = kWorthTelling * 0.9;
  const Insight insight =
      InsightOf({Made({Over("wall_mesial", below, 0.1), Over("wall_distal", below, 0.1)}),
                 Made({Over("wall_mesial", kWorthTelling, 0.2)})});
  ASSERT_EQ(insight.mistakes.size(), 1u);
  EXPECT_EQ(insight.mistakes[0].place, "wall_mesial");
  EXPECT_EQ(insight.mistakes[0].students, 1u);
  EXPECT_DOUBLE_EQ(insight.mistakes[0].points, kWorthTelling);
  EXPECT_DOUBLE_EQ(insight.mistakes[0].size, 0.2);
}

TEST(InsightTest, TheCommonestMistakeIsTheOneThatMostMadeAndThenTheDearest) {
  const Insight insight =
      InsightOf({Made({Over("wall_mesial", 20, 0.9)}),
                 Made({Over("wall_distal", 2, 0.1), Over("wall_buccal", 3, 0.1)}),
                 Made({Over("wall_distal", 2, 0.1), Over("wall_buccal", 3, 0.1)})});
  ASSERT_TRUE(insight.commonest.has_value());
  EXPECT_EQ(insight.mistakes[*insight.commonest].place, "wall_buccal");
  EXPECT_EQ(insight.mistakes[0].place, "wall_mesial") << "one student, who lost the most";
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

TEST(InsightTest, AForceFarFromTheClassStandsOutAndAGroupHasNoFigure) {
  std::vector<StudentWork> work;
  for (int i = 0; i < 8; ++i)
    work.push_back(Work(80, 1, {Outline(i == 0 ? 90 : i), Force(1 + 0.1 * i, 0)}));
  work[3].criteria[1].value = 40;
  const Insight insight = InsightOf(work);
  ASSERT_EQ(insight.outliers.size(), 1u);
  EXPECT_EQ(insight.outliers[0].student, 3u);
  EXPECT_EQ(insight.outliers[0].what, "force_sent_p95_n");
}

}  // namespace
}  // namespace enamel::server
