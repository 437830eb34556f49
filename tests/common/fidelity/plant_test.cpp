#include "common/fidelity/plant.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/fidelity/hands.h"

namespace enamel::fidelity {
namespace {

PlantSpec Bare(int substeps) {
  PlantSpec s;
  s.mass_kg = 0.1;
  s.resolution_m = 1e-9;
  s.substeps = substeps;
  return s;
}

// m v' + b v = F from rest: v = F/b (1 - exp(-b t/m)). Second order in the step dt = T/substeps: relative error below
// (b dt / m)^2 / 12.
TEST(PlantTest, DampedMassFollowsItsClosedForm) {
  PlantSpec s = Bare(8);
  s.damping_n_s_per_m = 5;
  ForceHand hand(dvec3(1, 0, 0), 2, 0, 0);
  Plant plant(s, hand, dvec3(0));
  for (int k = 0; k < 40; ++k) plant.Step(dvec3(0));
  double expected = 2.0 / 5 * (1 - std::exp(-5 * 0.04 / 0.1));
  const double step = 5 * 1e-3 / (8 * 0.1);
  EXPECT_NEAR(plant.speed_m_per_s().x, expected, expected * step * step / 12);
}

class SpringAtRest final : public Hand {
 public:
  static constexpr double kStiffness_n_per_m = 2000;
  Grip At(double) override {
    Grip out;
    out.stiffness_n_per_m = kStiffness_n_per_m;
    return out;
  }
};

// A mass on a hand's spring swings for ever: x = x0 cos(w t), w^2 = k/m. Its energy stays as it was, and its phase is
// late by (w dt)^2 / 12 of itself. Implicit Euler loses half of the energy here.
TEST(PlantTest, ASpringGivesBackWhatItTook) {
  constexpr double kFrom_m = 1e-3;
  PlantSpec s = Bare(4);
  SpringAtRest hand;
  Plant plant(s, hand, dvec3(kFrom_m, 0, 0));
  const double w = std::sqrt(SpringAtRest::kStiffness_n_per_m / s.mass_kg);
  for (int tick = 1; tick <= 100; ++tick) {
    plant.Step(dvec3(0));
    const double x = plant.tip_m().x, v = plant.speed_m_per_s().x;
    EXPECT_NEAR(std::hypot(x, v / w), kFrom_m, 1e-9 * kFrom_m);
    const double phase = w * 1e-3 * tick;
    EXPECT_NEAR(x, kFrom_m * std::cos(phase),
                kFrom_m * phase * (w * 1e-3 / 4) * (w * 1e-3 / 4) / 10);
  }
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

// The cells of a rotated lattice of edge delta are still cubes. The reading is never further from
// the tip than half a cell's diagonal, and never more than half a cell along each joint; both are
// nearly reached. Rounding by the driver adds half a driver cell per axis, on its multiples.
TEST(PlantTest, JointCellsReadTheirMiddleBackInCartesianCoordinates) {
  const double delta = 10e-6, driver = 25e-6;
  Random random(7);
  double furthest = 0, furthest_joint = 0, furthest_rounded = 0;
  for (int i = 0; i < 3000; ++i) {
    PlantSpec s = Bare(1);
    s.resolution_m = delta;
    const dvec3 a = random.Direction(), b = glm::normalize(glm::cross(a, random.Direction()));
    s.lattice.joints = glm::transpose(glm::dmat3(a, b, glm::cross(a, b)));
    ForceHand hand(dvec3(1, 0, 0), 0, 0, 0);
    const dvec3 tip(1e-3 * random.Signed(), 1e-3 * random.Signed(), 1e-3 * random.Signed());
    const dvec3 off = Plant(s, hand, tip).Read() - tip;
    furthest = std::max(furthest, glm::length(off));
    for (const dvec3& joint : {a, b, glm::cross(a, b)})
      furthest_joint = std::max(furthest_joint, std::fabs(glm::dot(joint, off)));
    s.lattice.driver_cell_m = driver;
    const dvec3 rounded = Plant(s, hand, tip).Read();
    for (int k = 0; k < 3; ++k) {
      furthest_rounded = std::max(furthest_rounded, std::fabs(rounded[k] - (tip + off)[k]));
      EXPECT_NEAR(std::remainder(rounded[k], driver), 0, 1e-12);
    }
  }
  EXPECT_LE(furthest, std::sqrt(0.75) * delta * (1 + 1e-9));
  EXPECT_GE(furthest, 0.9 * std::sqrt(0.75) * delta);
  EXPECT_NEAR(furthest_joint, delta / 2, 0.01 * delta);
  EXPECT_LE(furthest_rounded, driver / 2 * (1 + 1e-9));
  EXPECT_GE(furthest_rounded, 0.48 * driver);
}

// Two joints at 60 degrees: unit rows, the cell a rhombus. For a tip one joint cell further along
// the first joint's dual direction, the reading is exactly that much further.
TEST(PlantTest, ShearedJointCellsKeepTheirEdgeAlongEachJoint) {
  PlantSpec s = Bare(1);
  s.resolution_m = 10e-6;
  const dvec3 first(1, 0, 0), second(0.5, std::sqrt(0.75), 0), third(0, 0, 1);
  s.lattice.joints = glm::transpose(glm::dmat3(first, second, third));
  ForceHand hand(dvec3(1, 0, 0), 0, 0, 0);
  // (1, -1/sqrt 3, 0): first joint turns by one cell, the others stand.
  const dvec3 step = 10e-6 * dvec3(1, -1 / std::sqrt(3.0), 0), from(3e-6, 4e-6, 5e-6);
  const dvec3 moved = Plant(s, hand, from + step).Read() - Plant(s, hand, from).Read();
  EXPECT_NEAR(glm::length(moved - step), 0, 1e-15);
}

TEST(PlantTest, NoiseIsWholeCountsWithinItsRangeAndTheSameWithinATick) {
  PlantSpec s = Bare(1);
  s.resolution_m = 10e-6;
  s.jitter_ratio = 0.3;
  ForceHand hand(dvec3(1, 0, 0), 0, 0, 0);
  Plant quiet(s, hand, dvec3(12e-6, -1e-6, 1e-6));
  s.lattice.noise_counts = 2;
  Plant noisy(s, hand, dvec3(12e-6, -1e-6, 1e-6));
  std::array<int, 5> seen{};
  for (int k = 0; k < 5000; ++k) {
    const dvec3 read = noisy.Read();
    ASSERT_EQ(read, noisy.Read());
    for (int i = 0; i < 3; ++i) {
      const double counts = (read[i] - quiet.Read()[i]) / s.resolution_m;
      ASSERT_NEAR(counts, std::round(counts), 1e-9);
      ASSERT_LE(std::fabs(counts), 2.001);
      ++seen[static_cast<size_t>(std::lround(counts) + 2)];
    }
    noisy.StepHeld();
    quiet.StepHeld();
    ASSERT_EQ(noisy.last_tick_s(), quiet.last_tick_s());  // noise leaves the jitter alone
  }
  // 15000 draws over 5 values: 3000 each, sd 49; five of them.
  for (int n : seen) EXPECT_NEAR(n, 3000, 245);
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

// The hand's own balance, apart from the plant's: what a grip pushes with less what it takes to move the hand's mass.
class Recorder final : public Hand {
 public:
  explicit Recorder(Hand& hand) : hand_(hand) {}
  double mass_kg() const override { return hand_.mass_kg(); }
  Grip At(double t_s) override { return last_ = hand_.At(t_s); }
  Grip last_;

 private:
  Hand& hand_;
};

TEST(PlantTest, TheForceInTheHandIsWhatTheHandPushesWith) {
  for (double mode_hz : {0.0, 60.0}) {
    PlantSpec s = Bare(1);  // one sub-step a tick: the tick's mean is the sub-step's
    s.mass_kg = 0.2;
    s.damping_n_s_per_m = 6;
    s.friction_n = 0.09;
    s.mode_hz = mode_hz;
    s.tick_s = 0.1e-3;
    ImpedanceHand hand({.direction = glm::normalize(dvec3(1, 2, 3)),
                        .speed_m_per_s = 20e-3,
                        .reverse_s = 0.05,
                        .tremor_m = 1e-3,
                        .tremor_hz = 9},
                       1000, 0.1, 8);
    Recorder recorder(hand);
    Plant plant(s, recorder, dvec3(0));
    double most = 0, moved = 0;
    int looked_at = 0;
    for (int k = 0; k < 1500; ++k) {
      const dvec3 was = plant.speed_m_per_s(), from = plant.tip_m();
      plant.Step(dvec3(-0.3, 0.2, 0.1 * (k % 7)));
      const Grip& g = recorder.last_;
      // The integrator takes spring and damper in the step's middle.
      const dvec3 speed = 0.5 * (was + plant.speed_m_per_s());
      const dvec3 pushed = (g.equilibrium_m - 0.5 * (from + plant.tip_m())) * 1000.0 +
                           (g.equilibrium_speed_m_per_s - speed) * 8.0 -
                           (plant.speed_m_per_s() - was) * (0.1 / s.tick_s);
      for (int axis = 0; axis < 3; ++axis) {
        // Where friction has stopped it, the middle's speed is not known here.
        if (plant.speed_m_per_s()[axis] == 0) continue;
        most = std::max(most, std::fabs(plant.in_hand_n()[axis] - pushed[axis]));
        ++looked_at;
      }
      moved = std::max(moved, glm::length(plant.tip_m() - from));
    }
    EXPECT_GT(moved, 1e-6);
    EXPECT_GT(looked_at, 3000) << mode_hz;
    EXPECT_LT(most, 1e-9) << mode_hz;
  }
}

TEST(PlantTest, APrescribedHandFeelsDampingAndFrictionOfEachAxisBesideTheMotors) {
  PlantSpec s = Bare(8);
  s.damping_n_s_per_m = 5;
  s.friction_n = 0.1;
  VelocityHand hand(
      {.direction = glm::normalize(dvec3(3, -4, 0)), .speed_m_per_s = 0.1, .stop_s = 0.5});
  Plant plant(s, hand, dvec3(0));
  for (int k = 0; k < 100; ++k) plant.Step(dvec3(-1, 0, 0.05));
  EXPECT_NEAR(plant.in_hand_n().x, 1 + 5 * 0.06 + 0.1, 1e-9);
  EXPECT_NEAR(plant.in_hand_n().y, 0 - 5 * 0.08 - 0.1, 1e-9);
  EXPECT_NEAR(plant.in_hand_n().z, 0, 1e-9) << "0.05 N of the motors, which friction takes";
  for (int k = 0; k < 500; ++k) plant.Step(dvec3(-1, 0, 0));
  EXPECT_NEAR(plant.in_hand_n().x, 0.9, 1e-9) << "at rest";
}

}  // namespace
}  // namespace enamel::fidelity
