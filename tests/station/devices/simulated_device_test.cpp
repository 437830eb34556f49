#include "station/devices/simulated_device.h"

#include <gtest/gtest.h>

#include <cmath>

namespace enamel::station {
namespace {

// Holds the device with a spring at one place, or not at all.
class StillHand final : public SimulatedOperator {
 public:
  StillHand(dvec3 start, HandDrive drive) : start_(start), drive_(drive) {}
  std::string Name() const override { return "still hand"; }
  dvec3 Start_m() const override { return start_; }
  HandDrive Act(const dvec3&, const dvec3&, double) noexcept override { return drive_; }
  double Progress() const noexcept override { return 0; }

 private:
  dvec3 start_;
  HandDrive drive_;
};

HandDrive Spring(const dvec3& at, double stiffness) {
  HandDrive drive;
  drive.equilibrium_m = at;
  drive.stiffness_n_per_m = stiffness;
  drive.max_force_n = 100;
  return drive;
}

PlantParams Phantom(int substeps = 16) {
  PlantParams p;
  p.mass_kg = 0.045;
  p.hand_mass_kg = 0;
  p.damping_n_s_per_m = 1.75;
  p.resolution_m = 10e-6;
  p.peak_force_n = 7.9;
  p.substeps = substeps;
  return p;
}

TEST(SimulatedDeviceTest, SwingsLikeADampedOscillator) {
  PlantParams p = Phantom(64);
  SimulatedDevice device(p, std::make_unique<StillHand>(dvec3(1e-3, 0, 0), Spring(dvec3(0), 1000)));
  double gamma = p.damping_n_s_per_m / (2 * p.mass_kg);
  double omega = std::sqrt(1000 / p.mass_kg - gamma * gamma);
  for (int i = 1; i <= 200; ++i) {
    device.ReadSample();
    double t = i * p.tick_s;
    double exact =
        1e-3 * std::exp(-gamma * t) * (std::cos(omega * t) + gamma / omega * std::sin(omega * t));
    EXPECT_NEAR(device.position_m().x, exact, 0.05e-6) << "tick " << i;
  }
}

TEST(SimulatedDeviceTest, SixteenSubstepsAreAsGoodAsManyAgainstAStiffHeldForce) {
  // The stiffest profile's spring (12 N/mm) rendered by the loop on the lightest device (45 g).
  auto run = [](int substeps) {
    PlantParams p = Phantom(substeps);
    p.damping_n_s_per_m = 6;
    p.friction_n = 0.09;
    SimulatedDevice device(p,
                           std::make_unique<StillHand>(dvec3(0.1e-3, 0, 0), Spring(dvec3(0), 500)));
    std::vector<double> out;
    for (int i = 0; i < 100; ++i) {
      DeviceSample s = device.ReadSample();
      device.SendForce(dvec3(-12e3 * s.counts[0] * p.resolution_m, 0, 0));
      out.push_back(device.position_m().x);
    }
    return out;
  };
  auto coarse = run(16), fine = run(1024);
  // Counts may flip a tick apart; until then the trajectories agree to a small part of a count.
  for (size_t i = 0; i < 10; ++i) EXPECT_NEAR(coarse[i], fine[i], 1e-6) << "tick " << i;
}

TEST(SimulatedDeviceTest, FrictionHoldsAgainstSmallForcesAndNotLargeOnes) {
  PlantParams p = Phantom();
  p.friction_n = 0.025;
  SimulatedDevice device(p, std::make_unique<StillHand>(dvec3(0), HandDrive{}));
  device.SendForce(dvec3(0.024, 0, 0));
  for (int i = 0; i < 100; ++i) device.ReadSample();
  EXPECT_EQ(device.position_m().x, 0);
  device.SendForce(dvec3(0.026, 0, 0));
  for (int i = 0; i < 100; ++i) device.ReadSample();
  EXPECT_GT(device.position_m().x, 0);
}

TEST(SimulatedDeviceTest, MotorsSaturateAtThePeakForce) {
  PlantParams p = Phantom(256);
  p.damping_n_s_per_m = 0;
  SimulatedDevice device(p, std::make_unique<StillHand>(dvec3(0), HandDrive{}));
  device.SendForce(dvec3(100, 0, 0));
  for (int i = 0; i < 10; ++i) device.ReadSample();
  // v = F t / m
  EXPECT_NEAR(device.velocity_m_per_s().x, 7.9 * 0.01 / 0.045, 1e-9);
}

// A hand that holds the device at a tilt.
class TiltedHand final : public SimulatedOperator {
 public:
  explicit TiltedHand(const Quat& tilt) : tilt_(tilt) {}
  std::string Name() const override { return "tilted"; }
  dvec3 Start_m() const override { return dvec3(0); }
  HandDrive Act(const dvec3&, const dvec3&, double) noexcept override {
    HandDrive hand;
    hand.orientation = tilt_;
    return hand;
  }
  double Progress() const noexcept override { return 0; }

 private:
  const Quat tilt_;
};

PlantParams Wrist(int substeps = 64) {
  PlantParams p = Phantom(substeps);
  p.inertia_kg_m2 = 1e-4;
  p.orientation_cell_rad = 300e-6;
  p.peak_torque_n_m = 0.2;
  return p;
}

// Turned only by the hand's spring: inertia I, stiffness k, damping d. Chord and angle differ by
// the cube of the angle.
TEST(SimulatedDeviceTest, TurnsLikeADampedOscillator) {
  const PlantParams p = Wrist();
  const double tilt = 0.02;
  SimulatedDevice device(
      p, std::make_unique<TiltedHand>(Quat{0, std::sin(tilt / 2), 0, std::cos(tilt / 2)}));
  const double gamma = p.hand_n_m_s / (2 * p.inertia_kg_m2);
  const double omega = std::sqrt(p.hand_n_m_per_rad / p.inertia_kg_m2 - gamma * gamma);
  for (int i = 1; i <= 100; ++i) {
    const DeviceSample s = device.ReadSample();
    const double t = i * p.tick_s;
    const double exact =
        tilt *
        (1 - std::exp(-gamma * t) * (std::cos(omega * t) + gamma / omega * std::sin(omega * t)));
    ASSERT_NEAR(2 * device.orientation().y, exact, 0.002 * tilt) << i;
    // The recorded value is within a cell of the true one.
    const Quat error = FromQuantised(s.orientation) * device.orientation().Conjugate();
    ASSERT_LE(2 * std::sqrt(error.x * error.x + error.y * error.y + error.z * error.z), 300e-6);
  }
}

TEST(SimulatedDeviceTest, FeelsTheTorqueUpToItsPeakAndLateByTheBus) {
  PlantParams p = Wrist();
  p.rotational_friction_n_m = 1e-3;
  p.delay_ticks = 2;
  SimulatedDevice device(p, std::make_unique<TiltedHand>(Quat{}));
  device.SendForceAndTorque(dvec3(0), dvec3(0.0009, 0, 0));
  for (int i = 0; i < 100; ++i) device.ReadSample();
  EXPECT_EQ(device.orientation().x, 0) << "friction holds it";
  device.SendForceAndTorque(dvec3(0), dvec3(1, 0, 0));
  device.ReadSample();
  device.ReadSample();
  EXPECT_EQ(device.orientation().x, 0);
  for (int i = 0; i < 2000; ++i) device.ReadSample();
  EXPECT_NEAR(2 * device.orientation().x, 0.2, 0.002) << "0.2 N m against 1 N m/rad";
  device.SendForce(dvec3(0));
  for (int i = 0; i < 2000; ++i) device.ReadSample();
  EXPECT_NEAR(2 * device.orientation().x, 0, 0.0011) << "a force alone has no torque";
}

TEST(SimulatedDeviceTest, TheGimbalOfADeviceOfThreeAxesGoesWithTheHandWhateverTheTorque) {
  const Quat held = Quat{0.1, 0, 0, 1}.Normalised();
  SimulatedDevice device(Phantom(), std::make_unique<TiltedHand>(held));
  device.SendForceAndTorque(dvec3(0), dvec3(1, 0, 0));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(device.ReadSample().orientation, ToQuantised(held));
}

TEST(SimulatedDeviceTest, CountsAreTheNearestCellFromTheOrigin) {
  PlantParams p = Phantom();
  p.origin_m = dvec3(1e-3, 0, -2e-3);
  p.friction_n = 1;
  SimulatedDevice device(
      p, std::make_unique<StillHand>(dvec3(1.0149e-3, -14e-6, -2.0051e-3), HandDrive{}));
  EXPECT_EQ(device.ReadSample().counts, (std::array<int32_t, 3>{1, -1, -1}));
}

}  // namespace
}  // namespace enamel::station
