#include "common/fidelity/felt.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/fidelity/budget.h"
#include "common/fidelity/feel.h"
#include "common/fidelity/series.h"
#include "common/fidelity/tracks.h"
#include "common/fidelity/way.h"

namespace enamel::fidelity {
namespace {

// An Omega without friction, with cells so fine that only the spring is left.
FeltDevice Smooth(double kc) { return {0.05, 6, 0, 10e-9, kc, 1e3, 1e-3}; }

// To and fro at one frequency, from rest.
std::vector<dvec3> Sine(double amplitude_m, double omega, double seconds) {
  std::vector<dvec3> way;
  for (int i = 0; i < static_cast<int>(seconds / kWayStep_s); ++i)
    way.push_back(dvec3(1, 0, 0) * (amplitude_m * std::sin(omega * i * kWayStep_s)));
  return way;
}

// H = kt s/(s + kt/B) of plain Maxwell against the ideal damper, both in a grip of kh.
TEST(FeltTest, PlainMaxwellIsOffByTheClosedForm) {
  constexpr double kOmega = 1.6, kB = 6500;
  for (double grip : {300.0, 1000.0, 5000.0, 20'000.0}) {
    FeltTrial trial;
    trial.law = haptics::LawKind::kMaxwell;
    trial.hand.stiffness_n_per_m = grip;
    trial.from_s = 15;  // the transients of 1/(kt/B) are gone
    const FeltFigures f = Feel(Smooth(10e3), trial, Sine(1e-3, kOmega, 40));
    const double closed = ClosedFormError(grip, 10e3, kB, kOmega);
    EXPECT_NEAR(f.command_error(), closed, 0.03 * closed + 0.002) << grip;
  }
}

// With n Kc in place of Kc: the default law is as good as a spring of its stiffness for slow motion, less
// what its lag costs.
TEST(FeltTest, TheDefaultLawIsFeltAsAStifferSpring) {
  constexpr double kOmega = 1.6, kB = 6500;
  for (double grip : {1000.0, 5000.0}) {
    FeltTrial trial;
    trial.hand.stiffness_n_per_m = grip;
    trial.from_s = 15;
    const double error = Feel(Smooth(10e3), trial, Sine(1e-3, kOmega, 40)).command_error();
    EXPECT_LT(error, 0.75 * ClosedFormError(grip, 10e3, kB, kOmega)) << grip;
    EXPECT_GT(error, 0.9 * ClosedFormError(grip, 38e3, kB, kOmega)) << grip;
  }
}

// An ideal damper as an infinitely stiff coupling would be it: no error against itself.
TEST(FeltTest, AStiffSpringIsNoFartherFromTheIdealThanItsClosedForm) {
  FeltTrial trial;
  trial.law = haptics::LawKind::kMaxwell;
  trial.hand.stiffness_n_per_m = 300;
  FeltDevice stiff = Smooth(1e6);
  stiff.damping_n_s_per_m = 600;                                             // Kc <= 2 b/T
  EXPECT_LT(Feel(stiff, trial, Sine(1e-3, 1.6, 10)).command_error(), 0.03);  // a cell is 10 mN
}

// Friction is in both simulations, and charged to neither.
TEST(FeltTest, FrictionOfTheDeviceIsNotChargedToTheLaw) {
  FeltDevice rubs = Smooth(10e3);
  rubs.friction_n = 0.3;
  FeltTrial trial;
  trial.law = haptics::LawKind::kMaxwell;
  trial.hand.stiffness_n_per_m = 1000;
  const std::vector<dvec3> way = Sine(2e-3, 1.6, 20);
  const FeltFigures with = Feel(rubs, trial, way);
  const double without = Feel(Smooth(10e3), trial, way).command_error();
  EXPECT_LT(with.command_error(), without + 0.1);
  // Against B v without friction it would be more than twice as far off: 0.3 N of some 1.5.
  EXPECT_LT(with.ideal_rms_n, 0.85 * Feel(Smooth(10e3), trial, way).ideal_rms_n);
}

TEST(FeltTest, ADamperInAPrescribedHandIsBTimesItsSpeedUpToTheCeiling) {
  FeltDevice d = Smooth(10e3);
  d.peak_force_n = 2;
  FeltTrial trial;
  trial.from_s = 1;
  // 0.2 mm/s is 1.3 N; 0.43 mm/s would be 2.8 N.
  for (double speed : {0.2e-3, 0.43e-3}) {
    std::vector<dvec3> way;
    for (int i = 0; i < 3000; ++i) way.push_back(dvec3(1, 0, 0) * (speed * i * kWayStep_s));
    EXPECT_NEAR(Feel(d, trial, way).ideal_rms_n, std::min(6500 * speed, 2.0), 1e-3) << speed;
  }
}

// A filter of first order would call a fifteenth of the force of a stroke a second ripple.
TEST(FeltTest, AStrokeIsNoRipple) {
  FeltTrial trial;
  trial.hand.stiffness_n_per_m = 1000;
  trial.from_s = 2;
  const FeltFigures f = Feel(Smooth(10e3), trial, Sine(0.2e-3, 2 * M_PI, 10));
  EXPECT_GT(f.ideal_rms_n, 0.1);
  EXPECT_LT(f.ripple_n, 0.01 * f.ideal_rms_n);
}

TEST(FeltTest, RepeatsToTheBit) {
  FeltTrial trial;
  trial.hand.stiffness_n_per_m = 700;
  const std::vector<dvec3> way = Sine(1e-3, 1.6, 4);
  EXPECT_EQ(Feel(Smooth(10e3), trial, way).error_rms_n, Feel(Smooth(10e3), trial, way).error_rms_n);
}

// An Omega with its cells and friction, its spring on the board at 8 kHz; Kc by friction, 2c/delta.
FeltDevice OnBoard(int late) {
  FeltDevice d{0.2, 6, 0.09, 9e-6, 20e3, 12, 1e-3};
  d.board = {8, 1, late};
  return d;
}

// Twice the Kc that a tick of a millisecond allows: a quarter less error at least, though reports are late.
TEST(FeltTest, ASpringOnTheBoardIsFeltBetterHoweverLateItsReports) {
  FeltTrial trial;
  trial.hand.stiffness_n_per_m = 5000;
  const std::vector<dvec3> way = Sine(0.4e-3, 1.6, 8);
  FeltDevice host = OnBoard(0);
  host.kc_n_per_m = 10e3;
  host.board = {};
  const double at_host = Feel(host, trial, way).command_error();
  for (int late : {0, 1, 2}) {
    const FeltFigures f = Feel(OnBoard(late), trial, way);
    EXPECT_LT(f.command_error(), 0.75 * at_host) << late;
    EXPECT_GE(f.energy_min_j, -1e-12) << late;
  }
}

// Within the friction that its cell needs a tip sticks, and the spring keeps what force it has: a hand that
// gives feels up to Kc delta/2 of it. Half of Kc halves that.
TEST(FeltTest, InALightHandTheCellDecides) {
  FeltTrial trial;
  trial.hand.stiffness_n_per_m = 300;
  const std::vector<dvec3> way = Sine(0.4e-3, 1.6, 8);
  FeltDevice half = OnBoard(1);
  half.kc_n_per_m /= 2;
  const double whole_n = Feel(OnBoard(1), trial, way).error_rms_n;
  EXPECT_LE(whole_n, 20e3 * 9e-6 / 2);
  EXPECT_NEAR(Feel(half, trial, way).error_rms_n, whole_n / 2, 0.25 * whole_n);
}

// What the map asks (feel.h): the error of the grip's force. Without friction it is the closed form's; hand and
// device have mass and damping of their own, which take a little of that force.
TEST(FeelTest, WithoutFrictionTheGripFeelsTheClosedForm) {
  FeltTrial trial;
  trial.law = haptics::LawKind::kMaxwell;
  trial.from_s = 15;
  const std::vector<dvec3> ways[] = {Sine(1e-3, kHand_rad_per_s, 40)};
  const double closed = ClosedFormError(1000, 10e3, 6500, kHand_rad_per_s);
  EXPECT_NEAR(FeltIn(Smooth(10e3), trial, 1000, ways), closed, 0.1 * closed);
}

// Where the spring is too stiff to be felt, friction is all of the error. (In a soft spring's lag it can be of
// help: it is there at once.)
TEST(FeelTest, FrictionOfTheDeviceIsFelt) {
  FeltTrial trial;
  trial.law = haptics::LawKind::kMaxwell;
  trial.from_s = 15;
  FeltDevice rubs = Smooth(1e6);
  rubs.damping_n_s_per_m = 600;  // Kc <= 2 b/T
  const std::vector<dvec3> ways[] = {Sine(0.3e-3, kHand_rad_per_s, 30)};
  const double without = FeltIn(rubs, trial, 5000, ways);
  rubs.friction_n = 0.5;
  EXPECT_GT(FeltIn(rubs, trial, 5000, ways), without + 0.03);
}

// A prescribed hand that goes along x: the tool resists with B v, the device with c and b v more.
TEST(FeltTest, WhatTheDeviceAddsIsFelt) {
  FeltDevice rubs = Smooth(10e3);
  rubs.friction_n = 0.3;
  FeltTrial trial;
  trial.from_s = 4;  // six time constants of B/Kc: the law's own error is some 7 mN
  std::vector<dvec3> way;
  for (int i = 0; i < 8000; ++i) way.push_back(dvec3(1, 0, 0) * (0.2e-3 * i * kWayStep_s));
  const FeltFigures f = Feel(rubs, trial, way);
  EXPECT_NEAR(f.tool_rms_n, 1.3, 1e-6);
  EXPECT_NEAR(f.felt_error_rms_n, 0.3 + 6 * 0.2e-3, 0.02);
  EXPECT_NEAR(f.felt_error_p95_n, f.felt_error_rms_n, 0.02);
  EXPECT_LT(f.error_rms_n, 0.02) << "and the command is not to blame";
  ASSERT_EQ(f.seconds.size(), 3u);
  EXPECT_NEAR(f.seconds[2].error_rms_n / f.seconds[2].tool_rms_n, 0.3 / 1.3, 0.02);
}

// The same hand: its damping does not change with the device that it holds.
TEST(FeltTest, AToolThatIsHardlyThereIsNoDifferentFromTheIdealOne) {
  FeltDevice device = Smooth(10e3);
  device.mass_kg = 1e-6;
  device.damping_n_s_per_m = 0;
  FeltTrial trial;
  trial.hand.stiffness_n_per_m = 1000;
  trial.hand = SameHand(trial.hand, 0.2);
  const std::vector<dvec3> way = Sine(1e-3, 1.6, 6);
  const Series off = Difference(ForceInHand(device, trial, way, true),
                                ForceInHand(ToolOf(device), trial, way, true));
  EXPECT_LT(RmsOf(off), 1e-5);
}

TEST(BudgetTest, TheSharesAddUpAndEachCauseIsFoundWhereItIs) {
  FeltTrial trial;
  trial.hand.stiffness_n_per_m = 1000;
  const std::vector<dvec3> way = Sine(0.4e-3, 1.6, 8);
  struct Case {
    const char* cause;
    FeltDevice device;
    int delay_ticks;
  };
  FeltDevice rubs = Smooth(1e6), weak = rubs, coarse = rubs, heavy = rubs;
  rubs.friction_n = 0.5;
  weak.peak_force_n = 0.2;
  coarse.resolution_m = 9e-6;
  coarse.kc_n_per_m = 100e3;
  heavy.mass_kg = 100;
  const Case cases[] = {{"friction", rubs, 0},
                        {"saturation", weak, 0},
                        {"quantisation", coarse, 0},
                        {"inertia", heavy, 0},
                        {"lag", Smooth(1e3), 0}};
  for (Case one : cases) {
    one.device.damping_n_s_per_m = one.device.kc_n_per_m * 0.6e-3;  // Kc <= 2 b/T
    if (one.cause == std::string("lag")) trial.law = haptics::LawKind::kMaxwell;
    const FeltBudget budget = BudgetOf(one.device, trial, way);
    double sum = 0;
    const FeltPart* largest = &budget.parts[0];
    for (const FeltPart& p : budget.parts) {
      sum += p.share;
      if (p.share > largest->share && p.cause != std::string("damping")) largest = &p;
    }
    EXPECT_NEAR(sum, 1, 1e-9) << one.cause;
    EXPECT_STREQ(largest->cause, one.cause);
    // The budget's whole is what Feel finds.
    EXPECT_NEAR(budget.rms_n, Feel(one.device, trial, way).felt_error_rms_n, 1e-3 * budget.rms_n);
  }
}

TEST(SeriesTest, AreCountedAsTheyAreWritten) {
  const Series v = {{3, 4, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 2}};
  EXPECT_NEAR(RmsOf(v), std::sqrt((25.0 + 0 + 1 + 4) / 4), 1e-12);
  EXPECT_EQ(WithinOf(v, 0.75), 2);
  EXPECT_EQ(WithinOf(v, 1), 5);
  EXPECT_EQ(WithinOf({}, 0.95), 0);
  ASSERT_EQ(MeansOf(v, 3).size(), 1u);
  EXPECT_NEAR(glm::length(MeansOf(v, 3)[0] - dvec3(1, 5.0 / 3, 0)), 0, 1e-12);
  EXPECT_EQ(Difference(v, {{1, 1, 1}}), (Series{{2, 3, -1}}));
}

}  // namespace
}  // namespace enamel::fidelity
