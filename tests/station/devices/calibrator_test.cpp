#include "station/devices/calibrator.h"

#include <gtest/gtest.h>

#include <cmath>

#include "station/devices/simulated_device.h"
#include "station/qualify/plant.h"

namespace enamel::station {
namespace {

struct Truth {
  const char* name;
  double cell_m, noise_m, friction_n, damping_n_s_per_m, mass_kg;
  int delay_ticks;
  double rate_hz = 1000;
};

// Reports in counts finer than its cell, as a board that interpolates would.
DeviceSample Finer(DeviceSample s, double cells_per_count) {
  for (auto& c : s.counts) c = static_cast<int32_t>(std::lround(c * cells_per_count));
  return s;
}

std::array<AxisFigures, 3> Measure(const Truth& truth, double count_m) {
  PlantParams p;
  p.mass_kg = truth.mass_kg;
  p.hand_mass_kg = 0;
  p.damping_n_s_per_m = truth.damping_n_s_per_m;
  p.friction_n = truth.friction_n;
  p.resolution_m = truth.cell_m;
  p.noise_m = truth.noise_m;
  p.delay_ticks = truth.delay_ticks;
  p.peak_force_n = 8;
  p.tick_s = 1 / truth.rate_hz;
  SimulatedDevice device(p, std::make_unique<NobodyHolding>());
  CalibratorSetup setup;
  setup.count_m.fill(count_m);
  setup.tick_s = p.tick_s;
  Calibrator calibrator(setup);
  while (!calibrator.done()) {
    device.SendForce(calibrator.Step(Finer(device.ReadSample(), truth.cell_m / count_m)));
  }
  auto figures = calibrator.Figures();
  EXPECT_TRUE(figures.ok()) << truth.name << ": " << figures.status().message();
  return figures.ok() ? *figures : std::array<AxisFigures, 3>{};
}

void ExpectAgrees(const Truth& truth, const std::array<AxisFigures, 3>& axes) {
  for (const AxisFigures& a : axes) {
    EXPECT_NEAR(a.resolution_m.value, truth.cell_m, 0.02 * truth.cell_m) << truth.name;
    EXPECT_NEAR(a.noise_m.value, truth.noise_m, 0.1 * truth.noise_m + truth.cell_m / 3)
        << truth.name;
    EXPECT_NEAR(a.friction_n.value, truth.friction_n, 0.05 * truth.friction_n + 0.003)
        << truth.name;
    EXPECT_NEAR(a.damping_n_s_per_m.value, truth.damping_n_s_per_m,
                0.1 * truth.damping_n_s_per_m + 0.05)
        << truth.name;
    EXPECT_NEAR(a.mass_kg.value, truth.mass_kg, 0.05 * truth.mass_kg + 0.002) << truth.name;
    EXPECT_NEAR(a.delay_ticks.value, truth.delay_ticks, 0.35) << truth.name;
  }
}

// Stated bounds: cell 2 %, noise 10 % and a third of a cell, friction 5 % and 3 mN, damping 10 %
// and 0.05 N s/m, mass 5 % and 2 g, delay 0.35 ticks.
TEST(CalibratorTest, FindsWhatASimulatedDeviceIs) {
  const Truth cases[] = {
      {"omega", 9e-6, 0, 0.09, 6, 0.25, 0},
      {"phantom", 10e-6, 0, 0.025, 1.75, 0.045, 0},
      {"bhhd", 20e-6, 0, 0.08, 2.5, 0.15, 0},
      {"touch, slow bus", 55e-6, 0, 0.04, 0.8, 0.045, 2},
      {"falcon, slower bus", 60e-6, 0, 0.3, 3, 0.4, 4},
      {"noisy", 5e-6, 10e-6, 0.05, 2, 0.1, 1},
      {"very noisy", 20e-6, 40e-6, 0.05, 2, 0.1, 1},
      {"without friction", 10e-6, 0, 0, 1.5, 0.08, 0},
      {"heavy, nearly undamped", 10e-6, 0, 0.06, 0.3, 0.5, 1},
      {"fine", 1e-6, 0, 0.02, 1, 0.06, 1},
  };
  for (const Truth& truth : cases) ExpectAgrees(truth, Measure(truth, truth.cell_m));
}

TEST(CalibratorTest, FindsThemAtOtherRates) {
  ExpectAgrees({"500 Hz", 10e-6, 0, 0.05, 2, 0.1, 1, 500},
               Measure({"500 Hz", 10e-6, 0, 0.05, 2, 0.1, 1, 500}, 10e-6));
  ExpectAgrees({"4 kHz", 10e-6, 0, 0.05, 2, 0.1, 6, 4000},
               Measure({"4 kHz", 10e-6, 0, 0.05, 2, 0.1, 6, 4000}, 10e-6));
}

TEST(CalibratorTest, CellIsFoundBehindCountsFinerThanIt) {
  for (double ratio : {7.0, 7.3, 20.0}) {
    Truth truth{"interpolating", ratio * 1e-6, 0, 0.05, 2, 0.1, 0};
    auto axes = Measure(truth, 1e-6);
    EXPECT_NEAR(axes[0].resolution_m.value, truth.cell_m, 0.02 * truth.cell_m) << ratio;
  }
}

// The same against another simulation of a device, written for the force laws' qualification.
TEST(CalibratorTest, AgreesWithAnIndependentSimulation) {
  class Free final : public qualify::Hand {
   public:
    qualify::Grip At(double) override { return {}; }
  };
  qualify::PlantSpec spec;
  spec.mass_kg = 0.12;
  spec.damping_n_s_per_m = 2.2;
  spec.friction_n = 0.06;
  spec.resolution_m = 15e-6;
  spec.delay_ticks = 2;
  spec.substeps = 32;
  Free hand;
  qualify::Plant plant(spec, hand, dvec3(0));
  CalibratorSetup setup;
  setup.count_m.fill(15e-6);
  Calibrator calibrator(setup);
  while (!calibrator.done()) {
    DeviceSample s;
    dvec3 at = plant.Read();
    for (int i = 0; i < 3; ++i) {
      s.counts[static_cast<size_t>(i)] = static_cast<int32_t>(std::lround(at[i] / 15e-6));
    }
    plant.Step(calibrator.Step(s));
  }
  auto axes = calibrator.Figures();
  ASSERT_TRUE(axes.ok()) << axes.status().message();
  ExpectAgrees({"plant", 15e-6, 0, 0.06, 2.2, 0.12, 2}, *axes);
}

// A mass with damping, one axis like another, whose forces arrive after any part of a tick.
class LateDevice {
 public:
  LateDevice(double mass_kg, double b, double cell_m, double delay_ticks)
      : mass_kg_(mass_kg), b_(b), cell_m_(cell_m), delay_(delay_ticks) {}
  void Send(const dvec3& force_n) { sent_.push_back(force_n); }
  DeviceSample Read() {
    constexpr int kSteps = 200;
    const double dt = 1e-3 / kSteps;
    for (int i = 0; i < kSteps && !sent_.empty(); ++i) {
      double at = static_cast<double>(sent_.size() - 1) + (i + 0.5) / kSteps - delay_;
      dvec3 force = at < 0 ? dvec3(0) : sent_[static_cast<size_t>(at)];
      v_ += (force - v_ * b_) * (dt / mass_kg_);
      x_ += v_ * dt;
    }
    DeviceSample s;
    for (int i = 0; i < 3; ++i) {
      s.counts[static_cast<size_t>(i)] = static_cast<int32_t>(std::lround(x_[i] / cell_m_));
    }
    return s;
  }

 private:
  const double mass_kg_, b_, cell_m_, delay_;
  std::vector<dvec3> sent_;
  dvec3 x_{0}, v_{0};
};

// Nine tenths of it never exceed the limit for the true delay, Kc <= 2 b / ((d + 1)^2 T)
// (haptics/coupling.h), whatever part of a tick that is; nor is it given away.
TEST(CalibratorTest, APartOfATickOfDelayIsNotLeftOutOfTheLimitOfKc) {
  constexpr double kT = 1e-3, kDamping = 1.5;
  for (double d : {0.0, 0.2, 0.4, 0.5, 0.9, 1.0, 1.1, 1.4, 1.5, 2.6, 3.3}) {
    LateDevice device(0.08, kDamping, 10e-6, d);
    CalibratorSetup setup;
    setup.count_m.fill(10e-6);
    Calibrator calibrator(setup);
    while (!calibrator.done()) device.Send(calibrator.Step(device.Read()));
    auto axes = calibrator.Figures();
    ASSERT_TRUE(axes.ok()) << d << ": " << axes.status().message();
    const double limit = 2 * kDamping / (kT * (d + 1) * (d + 1));
    for (const AxisFigures& a : *axes) {
      EXPECT_NEAR(a.delay_ticks.value, d, 0.1) << d;
      const double kc = 0.9 * PassiveStiffness(kDamping, kT, a.delay_ticks);
      EXPECT_LE(kc, limit) << d;
      EXPECT_GE(kc, 0.55 * limit) << d;
    }
  }
}

TEST(CalibratorTest, IntervalsHoldTheTruthMostOfTheTime) {
  int inside = 0, all = 0;
  for (int i = 0; i < 12; ++i) {
    Truth truth{"interval", 10e-6, 5e-6, 0.03 + 0.01 * i, 1 + 0.4 * i, 0.05 + 0.02 * i, 1};
    for (const AxisFigures& a : Measure(truth, truth.cell_m)) {
      all += 2;
      // The interval is of the scatter; one per cent is allowed for the model.
      inside += std::fabs(a.damping_n_s_per_m.value - truth.damping_n_s_per_m) <=
                a.damping_n_s_per_m.uncertainty + 0.01 * truth.damping_n_s_per_m;
      inside += std::fabs(a.friction_n.value - truth.friction_n) <=
                a.friction_n.uncertainty + 0.01 * truth.friction_n;
    }
  }
  EXPECT_GE(inside, all * 8 / 10) << inside << " of " << all;
}

TEST(CalibratorTest, StopsWithZeroForceWhenUnpluggedSilentOrRunningAway) {
  auto outcome = [](auto change) {
    CalibratorSetup setup;
    setup.count_m.fill(10e-6);
    Calibrator calibrator(setup);
    DeviceSample s;
    dvec3 force(0);
    for (int tick = 0; tick < 100'000 && !calibrator.done(); ++tick) {
      change(tick, s);
      force = calibrator.Step(s);
    }
    EXPECT_EQ(force, dvec3(0));
    EXPECT_TRUE(calibrator.done());
    return calibrator.Figures().status().message();
  };
  EXPECT_NE(outcome([](int t, DeviceSample& s) { s.attached = t < 3000; }).find("unplugged"),
            std::string::npos);
  EXPECT_NE(outcome([](int t, DeviceSample& s) { s.fresh = t < 3000; }).find("silent"),
            std::string::npos);
  EXPECT_NE(
      outcome([](int t, DeviceSample& s) { s.counts[1] = t > 3000 ? t : 0; }).find("ran away"),
      std::string::npos);
  // Its motors are off.
  EXPECT_NE(outcome([](int, DeviceSample&) {}).find("did not move"), std::string::npos);
}

TEST(CalibratorTest, NeverAsksForMoreThanTheForceAllowed) {
  PlantParams p;
  p.mass_kg = 2;
  p.hand_mass_kg = 0;
  p.friction_n = 0.4;
  p.resolution_m = 10e-6;
  p.peak_force_n = 8;
  SimulatedDevice device(p, std::make_unique<NobodyHolding>());
  CalibratorSetup setup;
  setup.count_m.fill(10e-6);
  setup.max_force_n = 0.9;
  Calibrator calibrator(setup);
  while (!calibrator.done()) {
    dvec3 f = calibrator.Step(device.ReadSample());
    for (int i = 0; i < 3; ++i) ASSERT_LE(std::fabs(f[i]), 0.9);
    device.SendForce(f);
  }
}

}  // namespace
}  // namespace enamel::station
