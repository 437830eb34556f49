#include "station/sdk/falcon_arm.h"

#include <gtest/gtest.h>

#include <functional>

#include "common/scene/find_profile.h"
#include "tests/station/sdk/emulated_falcon.h"

// The driver's kinematics against libnifalcon's inverse, another formula.
namespace enamel::station::sdk::falcon {
namespace {

using testing_support::FalconAnglesAt;

// Places of the workspace by 8 mm, with its rim.
void ForEachPlace(const std::function<void(const dvec3&)>& check) {
  const double reach = scene::FindProfile("falcon")->workspace_radius_um.value * 1e-6;
  const int steps = static_cast<int>(reach / 0.008);
  for (int x = -steps; x <= steps; ++x) {
    for (int y = -steps; y <= steps; ++y) {
      for (int z = -steps; z <= steps; ++z) {
        const dvec3 off = dvec3(x, y, z) * (reach / steps);
        if (Dot(off, off) <= reach * reach) check(kMiddle_m + off);
      }
    }
  }
}

double Length(const dvec3& v) { return std::sqrt(Dot(v, v)); }

// How the tip moves with a thigh, by differences.
dvec3 MovesBy(const dvec3& angles, const dvec3& tip, int thigh) {
  constexpr double kTurn = 1e-6;
  dvec3 more = angles, less = angles;
  more[thigh] += kTurn;
  less[thigh] -= kTurn;
  return (*TipOf(more, tip) - *TipOf(less, tip)) / (2 * kTurn);
}

TEST(FalconArmTest, TheTipOfItsAnglesIsWhereTheyAreFrom) {
  int places = 0;
  ForEachPlace([&](const dvec3& place) {
    const dvec3 angles = FalconAnglesAt(place);
    for (const dvec3& near : {kMiddle_m, place + dvec3(0.003, -0.002, 0.004)}) {
      const auto tip = TipOf(angles, near);
      ASSERT_TRUE(tip.has_value());
      EXPECT_LT(Length(*tip - place), 1e-9);
    }
    ++places;
  });
  EXPECT_GT(places, 500);
}

TEST(FalconArmTest, ItsTorquesDoTheForcesWork) {
  ForEachPlace([](const dvec3& place) {
    const dvec3 angles = FalconAnglesAt(place), force{1.1, -2.3, 3.1};
    const auto torques = TorquesOf(force, place, angles);
    ASSERT_TRUE(torques.has_value());
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR((*torques)[i], Dot(force, MovesBy(angles, place, i)), 1e-8);
    }
  });
}

// A push out of the device lifts each thigh: with motors the other way round it would pull.
TEST(FalconArmTest, APushTowardTheUserOpensTheLegs) {
  const auto torques = TorquesOf({0, 0, 1}, kMiddle_m, FalconAnglesAt(kMiddle_m));
  for (int i = 0; i < 3; ++i) EXPECT_GT((*torques)[i], 0.01);
}

TEST(FalconArmTest, AnglesThatNoTipHasAreRefused) {
  // One leg far out and two far in; and beyond a shin's reach to the side.
  EXPECT_FALSE(TipOf({2.2, -1, -1}, kMiddle_m).has_value());
  EXPECT_FALSE(TipOf({0.5, 0.5, 0.5}, {0.2, 0, 0.1}).has_value());
  // Stretched legs have no one torque.
  EXPECT_FALSE(TorquesOf({0, 0, 1}, {0, 0, 0}, {0, 0, 0}).has_value());
}

TEST(FalconArmTest, ItsProfileHasTheLargestCountAndTheForceThatItsMotorsGiveEverywhere) {
  const auto profile = *scene::FindProfile("falcon");
  double most_m = 0, least_n = 1e9;
  ForEachPlace([&](const dvec3& place) {
    const dvec3 angles = FalconAnglesAt(place);
    for (int i = 0; i < 3; ++i) {
      const dvec3 by = MovesBy(angles, place, i);
      most_m = std::max(most_m, Length(by) * kRadPerCount);
      // The force along a thigh's own moves takes the largest torque of it.
      least_n = std::min(least_n, 4096 / 10'000.0 / Length(by));
    }
  });
  EXPECT_NEAR(profile.resolution_nm.value * 1e-9, most_m, 0.5e-6);
  EXPECT_LE(most_m, profile.resolution_nm.value * 1e-9);
  EXPECT_NEAR(profile.peak_force_mn.value * 1e-3, least_n, 0.1);
  EXPECT_LE(profile.peak_force_mn.value * 1e-3, least_n);
}

}  // namespace
}  // namespace enamel::station::sdk::falcon
