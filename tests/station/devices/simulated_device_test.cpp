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
