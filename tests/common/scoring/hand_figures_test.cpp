#include "common/scoring/movement/hand_figures.h"

#include <gtest/gtest.h>

#include <vector>

namespace enamel::scoring {
namespace {

HandRecord Of(double tremor_um, double still_percent, std::optional<double> near_share = 0.3) {
  HandRecord out;
  out.hand.tremor_nm = static_cast<int32_t>(tremor_um * 1e3);
  out.hand.still_ppm = static_cast<int32_t>(still_percent * 1e4);
  out.near_share = near_share;
  return out;
}

TEST(HandFiguresTest, FewAttemptsAreNotRanked) {
  const std::vector<HandRecord> four(kMinRanked - 1, Of(20, 30));
  EXPECT_FALSE(UnusualRank(four, 0).has_value());
}

TEST(HandFiguresTest, EqualAttemptsShareTheFirstPlace) {
  const std::vector<HandRecord> same(kMinRanked, Of(20, 30));
  for (size_t i = 0; i < same.size(); ++i) EXPECT_EQ(UnusualRank(same, i), 1u);
}

TEST(HandFiguresTest, WhatIsFarthestFromTheMiddleIsFirst) {
  const std::vector<HandRecord> records = {Of(20, 30), Of(22, 31), Of(18, 29),
                                           Of(21, 33), Of(1, 30),  Of(19, 45)};
  // Tremor: middle 19, deviations 1, 3, 1, 2, 18, 0: 18 / (1.4826 * 1). Still: middle 30, 15 / 1.48.
  EXPECT_EQ(UnusualRank(records, 4), 1u);
  EXPECT_EQ(UnusualRank(records, 5), 2u);
}

TEST(HandFiguresTest, NearIsUnusualAndFarIsNot) {
  std::vector<HandRecord> records(6, Of(20, 30));
  records[2].near_share = 0.01;
  records[3].near_share = 30;
  EXPECT_EQ(UnusualRank(records, 2), 1u);
  EXPECT_EQ(UnusualRank(records, 3), 2u) << "as all the others";
}

TEST(HandFiguresTest, WhatIsNotKnownIsNotUnusual) {
  std::vector<HandRecord> records(6, Of(20, 30));
  records[0].hand.tremor_nm = HandFigures::kNoTremor;
  records[0].near_share.reset();
  records[1].hand.late_ppm = 50'000;
  EXPECT_EQ(UnusualRank(records, 0), 2u);
  EXPECT_EQ(UnusualRank(records, 1), 1u);
}

TEST(HandFiguresTest, OnlyAMeasuredTremorIsTooCalm) {
  EXPECT_TRUE(IsTooCalm(Of(0.9 * kMinTremor_um, 0).hand));
  EXPECT_FALSE(IsTooCalm(Of(1.1 * kMinTremor_um, 0).hand));
  EXPECT_FALSE(IsTooCalm({}));
}

}  // namespace
}  // namespace enamel::scoring
