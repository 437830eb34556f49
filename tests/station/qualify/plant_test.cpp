#include "station/qualify/plant.h"

#include <gtest/gtest.h>

#include <cmath>

#include "station/qualify/hands.h"

namespace enamel::station::qualify {
namespace {

PlantSpec Bare(int substeps) {
  PlantSpec s;
  s.mass_kg = 0.1;
  s.resolution_m = 1e-9;
  s.substeps = substeps;
  return s;
}

// m v' + b v = F from rest: v = F/b (1 - exp(-b t/m)). First order in the step T/substeps: relative
// error below b T / (2 m substeps).
TEST(PlantTest, DampedMassFollowsItsClosedForm) {
  PlantSpec s = Bare(8);
  s.damping_n_s_per_m = 5;
  ForceHand hand(dvec3(1, 0, 0), 2, 0, 0);
  Plant plant(s, hand, dvec3(0));
  for (int k = 0; k < 40; ++k) plant.Step(dvec3(0));
  double expected = 2.0 / 5 * (1 - std::exp(-5 * 0.04 / 0.1));
  EXPECT_NEAR(plant.speed_m_per_s().x, expected, expected * 5 * 1e-3 / (2 * 0.1 * 8));
}

TEST(PlantTest, FrictionHoldsUpToItsForceAndTakesItFromMotion) {
  PlantSpec s = Bare(8);
  s.friction_n = 0.5;
  ForceHand weak(dvec3(1, 0, 0), 0.49, 0, 0), strong(dvec3(1, 0, 0), 0.7, 0, 0);
  Plant held(s, weak, dvec3(0)), moved(s, strong, dvec3(0));
  for (int k = 0; k < 100; ++k) {
    held.Step(dvec3(0));
    moved.Step(dvec3(0));
  }
  EXPECT_EQ(held.tip_m(), dvec3(0));
  EXPECT_NEAR(moved.speed_m_per_s().x, 0.2 / 0.1 * 0.1, 1e-9);
}

TEST(PlantTest, DelayPostponesTheForceByWholeTicks) {
  for (int delay : {0, 1, 3}) {
    PlantSpec s = Bare(4);
    s.delay_ticks = delay;
    ForceHand hand(dvec3(1, 0, 0), 0, 0, 0);
    Plant plant(s, hand, dvec3(0));
    int first = -1;
    for (int k = 0; k < 10 && first < 0; ++k) {
      plant.Step(dvec3(1, 0, 0));
      if (plant.speed_m_per_s().x > 0) first = k;
    }
    EXPECT_EQ(first, delay);
  }
}

TEST(PlantTest, MotorsSaturateAndCellsHaveMiddles) {
  PlantSpec s = Bare(4);
  s.peak_force_n = 3;
  s.resolution_m = 10e-6;
  ForceHand hand(dvec3(1, 0, 0), 0, 0, 0);
  Plant plant(s, hand, dvec3(12e-6, -1e-6, 0));
  EXPECT_NEAR(plant.Read().x, 15e-6, 1e-15);
  EXPECT_NEAR(plant.Read().y, -5e-6, 1e-15);
  plant.Step(dvec3(100, -100, 1));
  EXPECT_EQ(plant.sent_n(), dvec3(3, -3, 1));
}

// The free mode of two masses: omega as asked. The tip oscillates against the motor after a step of
// motor force; zero crossings of the difference give the frequency within 2 % (implicit Euler
// lowers it).
TEST(PlantTest, StructuralModeRingsAtItsFrequency) {
  PlantSpec s = Bare(200);
  s.mode_hz = 50;
  s.mode_damping_ratio = 0;
  ForceHand hand(dvec3(1, 0, 0), 0, 0, 0);
  Plant plant(s, hand, dvec3(0));
  int crossings = 0;
  double last = 0, mean = 0;
  // Steady offset of the spring under acceleration: tip share of the force.
  for (int k = 0; k < 400; ++k) {
    plant.Step(dvec3(1, 0, 0));
    mean += (plant.tip_m().x - plant.motor_m().x) / 400;
  }
  Plant again(s, hand, dvec3(0));
  for (int k = 0; k < 400; ++k) {
    again.Step(dvec3(1, 0, 0));
    double off = again.tip_m().x - again.motor_m().x - mean;
    if (last != 0 && off * last < 0) ++crossings;
    if (off != 0) last = off;
  }
  EXPECT_NEAR(crossings, 40, 2);
}

TEST(PlantTest, LosesTheShareOfTicksAskedFor) {
  PlantSpec s = Bare(1);
  s.drop_ratio = 0.1;
  ForceHand hand(dvec3(1, 0, 0), 0, 0, 0);
  Plant plant(s, hand, dvec3(0));
  int lost = 0;
  for (int k = 0; k < 20000; ++k) lost += plant.TickLost();
  EXPECT_NEAR(lost, 2000, 5 * std::sqrt(20000 * 0.1 * 0.9));
}

TEST(HandsTest, ReverseTurnsBackAtItsTime) {
  LineMotion m;
  m.speed_m_per_s = 1e-3;
  m.reverse_s = 2;
  EXPECT_NEAR(m.PositionAt(1).x, 1e-3, 1e-15);
  EXPECT_NEAR(m.PositionAt(3).x, 1e-3, 1e-15);
  EXPECT_LT(m.SpeedAt(3).x, 0);
}

}  // namespace
}  // namespace enamel::station::qualify
