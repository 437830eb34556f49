#include "common/scoring/board.h"

#include <gtest/gtest.h>

#include "common/scoring/score.h"

namespace enamel::scoring {
namespace {

constexpr size_t kTissue = 3;  // the row of what was preserved

ScoreResult WithPulp(double exposed_mm2, std::optional<double> uncertainty, const char* source) {
  scene::Rubric rubric;
  rubric.name = "class-1";
  rubric.prices = {{"wall", 0.5, 0.5, 10, 30, 2, 10, "a test"}};
  rubric.critical = {
      {"gross_overextension", "wall_mesial_mm", "mm", 1.3, true, "ADEX; milder here"},
      {"pulp_exposed", "pulp_exposed_mm2", "mm2", 0, true, source}};
  MetricSet metrics{{{"wall_mesial_mm", 2, "mm"}, {"pulp_exposed_mm2", exposed_mm2, "mm2"}}, {}};
  metrics.values[1].uncertainty = uncertainty;
  return *ApplyRubric(rubric, metrics, {{"wall_mesial", "wall", 0, 0}});
}

TEST(BoardTest, OnlyALimitThatWasReadGradesItsCategory) {
  const ScoreResult open = WithPulp(0.5, {}, "ADEX");
  ASSERT_EQ(open.board.size(), 4U);
  EXPECT_EQ(open.board[kTissue].category, Group::kTissuePreserved);
  EXPECT_EQ(open.board[kTissue].grade, BoardGrade::kCritical);
  EXPECT_EQ(open.board[kTissue].error, "pulp_exposed");
  EXPECT_EQ(open.board[kTissue].source, "ADEX");
  // The outline's error is critical, too, by a limit of ours.
  ASSERT_EQ(open.critical.size(), 2U);
  for (size_t i = 0; i < kTissue; ++i) EXPECT_FALSE(open.board[i].grade) << i;
  EXPECT_EQ(WithPulp(0, {}, "ADEX").board[kTissue].grade, BoardGrade::kSatisfactory);
  EXPECT_FALSE(WithPulp(0, {}, "chosen").board[kTissue].grade);
}

TEST(BoardTest, WhatTheMeasuringDoesNotDecideIsBorderline) {
  const BoardRow row = WithPulp(0.01, 0.01, "ADEX").board[kTissue];
  EXPECT_EQ(row.grade, BoardGrade::kSatisfactory);
  EXPECT_TRUE(row.borderline);
}

TEST(BoardTest, ItIsKeptWithTheScore) {
  const ScoreResult score = WithPulp(0.5, {}, "ADEX");
  const auto read = ScoreFromJson(ToJson(score));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->board, score.board);
}

}  // namespace
}  // namespace enamel::scoring
