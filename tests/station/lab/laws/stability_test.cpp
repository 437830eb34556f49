#include "station/lab/laws/stability.h"

#include <gtest/gtest.h>

#include <numbers>

#include "common/haptics/criteria.h"

namespace enamel::station::lab {
namespace {

constexpr double kTick_s = 1e-3;

PlantSpec Device(double mass_kg, double b, double c, double delta_m, int substeps) {
  PlantSpec s;
  s.mass_kg = mass_kg;
  s.damping_n_s_per_m = b;
  s.friction_n = c;
  s.resolution_m = delta_m;
  s.tick_s = kTick_s;
  s.substeps = substeps;
  return s;
}

// b is chosen here, far from K T/2 of any device: if it came from a stiffness, these could not
// agree.
TEST(StabilityTest, TheLargestPassiveSpringIsColgateSchenkelsForEveryDamping) {
  for (double b : {0.1, 0.7, 3.0, 20.0}) {
    double k = LargestPassive(Device(0.1, b, 0.02 * b, 10e-6, 1), Rendered::kSpring);
    EXPECT_NEAR(k, haptics::ColgateSchenkelStiffness(b, 0, kTick_s), 0.01 * k) << b;
  }
}

TEST(StabilityTest, TheLargestPassiveDamperIsTheDevicesOwnForEveryDamping) {
  for (double b : {0.1, 0.7, 3.0, 20.0}) {
    double damper = LargestPassive(Device(0.1, b, 0.02 * b, 10e-6, 1), Rendered::kDamper);
    EXPECT_NEAR(damper, b, 0.01 * b);
  }
}

TEST(StabilityTest, WhereFrictionIsLittleTheCellIsTheLimitAsInAbbottOkamura) {
  for (double c : {0.005, 0.02}) {
    PlantSpec device = Device(0.1, 5, c, 10e-6, 1);
    double k = LargestPassive(device, Rendered::kSpring);
    EXPECT_NEAR(k, haptics::AbbottOkamuraStiffness(5, kTick_s, c, 10e-6), 0.1 * k) << c;
    EXPECT_LT(k, 0.5 * haptics::ColgateSchenkelStiffness(5, 0, kTick_s));
    double damper = LargestPassive(device, Rendered::kDamper);
    EXPECT_NEAR(damper, c * kTick_s / 10e-6, 0.1 * damper) << c;
  }
}

TEST(StabilityTest, DelayTakesStiffnessAsInGil) {
  for (int delay : {1, 3}) {
    PlantSpec device = Device(0.1, 2, 0, 1e-12, 64);
    device.delay_ticks = delay;
    double k = LargestStable(device, Rendered::kSpring, {});
    EXPECT_NEAR(k, haptics::GilStiffness(2, 0, kTick_s, delay), 0.03 * k) << delay;
  }
}

// The poles of the linear system and of the simulation's own search; a sub-step in 64 shifts K by 2
// %.
TEST(StabilityTest, ADeviceAloneComesToRestUpToWhereItsPolesSay) {
  for (double mass : {0.045, 0.25}) {
    for (double b : {0.5, 8.0}) {
      PlantSpec device = Device(mass, b, 0, 1e-12, 64);
      double k = LinearStableSpring(mass, b, kTick_s),
             damper = LinearStableDamper(mass, b, kTick_s);
      EXPECT_NEAR(LargestStable(device, Rendered::kSpring, {}), k, 0.03 * k) << mass << " " << b;
      EXPECT_NEAR(LargestStable(device, Rendered::kDamper, {}), damper, 0.03 * damper)
          << mass << " " << b;
    }
  }
}

// With little damping the closed forms are 2 b / T and 2 m / T: a damper still comes to rest at a
// hundred times its passive limit.
TEST(StabilityTest, AtRestASpringIsLimitedByDampingAndADamperByMass) {
  EXPECT_NEAR(LinearStableSpring(0.1, 0.01, kTick_s), 2 * 0.01 / kTick_s, 1e-3);
  EXPECT_NEAR(LinearStableDamper(0.1, 0.01, kTick_s), 2 * 0.1 / kTick_s, 0.02);
}

// A mass under a damper that acts late by L: B L / m = pi / 2. Sample, hold and difference are one
// tick of L. The delay at which the paper's device of 0.25 kg vibrates at its printed 5.1 N s/m.
TEST(StabilityTest, ADamperShakesAMassAtThePrintedDampingOnlyWhenItActsSeventySevenTicksLate) {
  PlantSpec device = Device(0.25, 0.01, 0, 1e-12, 16);
  device.delay_ticks = 76;
  double damper = LargestStable(device, Rendered::kDamper, {});
  EXPECT_NEAR(damper, std::numbers::pi / 2 * 0.25 / 0.077, 0.03 * damper);
  EXPECT_NEAR(damper, 5.1, 0.1);
}

TEST(StabilityTest, AHandMakesASpringBearable) {
  PlantSpec device = Device(0.045, 1, 0.025, 10e-6, 64);
  Hold hand{0.05, 500, 4};
  EXPECT_GT(LargestStable(device, Rendered::kSpring, hand),
            2 * LargestStable(device, Rendered::kSpring, {}));
}

}  // namespace
}  // namespace enamel::station::lab
