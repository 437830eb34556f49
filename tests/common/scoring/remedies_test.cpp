#include "common/scoring/remedies.h"

#include <gtest/gtest.h>

#include "common/scoring/reasons.h"

namespace enamel::scoring {
namespace {

const std::vector<scene::RubricPoint> kAtMost = {{1, 1}, {3, 0}}, kAtLeast = {{1, 0}, {3, 1}};

TEST(RemediesTest, AForceAboveWhereFullMarksEndIsAHeavyHand) {
  for (const char* metric : {"force_sent_p95_n", "force_sent_max_n"}) {
    const MetricInfo& info = *FindMetric(metric);
    const Remedy* remedy = RemedyOf(info, 1.5, kAtMost);
    ASSERT_NE(remedy, nullptr) << metric;
    EXPECT_EQ(remedy->fault, "heavy_hand");
    EXPECT_EQ(remedy->code, "do_lighter");
    EXPECT_EQ(RemedyOf(info, 1, kAtMost), nullptr) << "nothing is lost";
    EXPECT_EQ(RemedyOf(info, 1.5, kAtLeast), nullptr) << "nobody is told to press harder";
  }
}

TEST(RemediesTest, EveryOtherFigureOfTheHandHasNone) {
  for (const MetricInfo& info : Metrics()) {
    if (info.name.starts_with("force_sent_p95") || info.name.starts_with("force_sent_max"))
      continue;
    for (const bool above : {false, true}) EXPECT_EQ(FindRemedy(info.name, above), nullptr);
  }
}

TEST(RemediesTest, ACodeThatIsNoRemedyHasNoText) {
  EXPECT_EQ(RemedyText("do_lighter"), "Press less and let the bur cut");
  EXPECT_TRUE(RemedyText("heavy_hand").empty());
  EXPECT_TRUE(RemedyText("").empty());
}

}  // namespace
}  // namespace enamel::scoring
