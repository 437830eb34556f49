#include "station/desk/hand_alignment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace enamel::station::desk {
namespace {

// What a device that stands turned by `deg` says of a hand that goes to the right.
dvec3 Seen(double deg, double way_m = kWayToTheRight_m + 1e-6) {
  const double angle = -deg * std::numbers::pi / 180;
  return way_m * dvec3(std::cos(angle), std::sin(angle), 0);
}

TEST(HandAlignmentTest, FindsTheNearestQuarterAndWhatIsLeft) {
  for (int deg = -135; deg < 225; deg += 5) {
    const auto found = StandingOf(Seen(deg));
    ASSERT_TRUE(found) << deg;
    EXPECT_EQ(found->turn_deg % 90, 0);
    EXPECT_GE(found->turn_deg, 0);
    EXPECT_LT(found->turn_deg, 360);
    EXPECT_LE(std::abs(found->askew_deg), 45) << deg;
    EXPECT_EQ((found->turn_deg + found->askew_deg - deg + 720) % 360, 0) << deg;
  }
}

TEST(HandAlignmentTest, AForearmsArcIsNotAskewAndATurnedBaseIs) {
  EXPECT_FALSE(StandingOf(Seen(8))->IsAskew());
  EXPECT_FALSE(StandingOf(Seen(90 - 8))->IsAskew());
  EXPECT_TRUE(StandingOf(Seen(12))->IsAskew());
  EXPECT_TRUE(StandingOf(Seen(90 - 12))->IsAskew());
}

TEST(HandAlignmentTest, AwaitsAFarAndLevelWay) {
  EXPECT_FALSE(StandingOf(Seen(0, kWayToTheRight_m - 1e-6)));
  EXPECT_FALSE(StandingOf(Seen(0) + dvec3(0, 0, 0.6 * kWayToTheRight_m)));
  HandAlignment alignment;
  EXPECT_FALSE(alignment.Look(Seen(0))) << "nobody asked";
  const dvec3 rest_m(0.01, 0.02, 0.03);
  alignment.Begin(rest_m);
  EXPECT_FALSE(alignment.Look(rest_m));
  EXPECT_TRUE(alignment.awaits_hand());
  EXPECT_TRUE(alignment.Look(rest_m + Seen(90)));
  EXPECT_FALSE(alignment.Look(rest_m + Seen(180))) << "once";
  EXPECT_EQ(alignment.found()->turn_deg, 90);
  alignment.Begin(rest_m);
  EXPECT_FALSE(alignment.found());
}

}  // namespace
}  // namespace enamel::station::desk
