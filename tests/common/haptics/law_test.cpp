#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/haptics/force_law.h"

namespace enamel::haptics {
namespace {

LawParams Omega() {
  LawParams p;
  p.kc_n_per_m = 10e3;
  p.resolution_m = dvec3(9e-6);
  return p;
}

TEST(LawRegistryTest, EveryLawIsFoundByNameAndKindAndMakesAnInstance) {
  EXPECT_EQ(ForceLaws().size(), 8u);
  for (const LawEntry& law : ForceLaws()) {
    EXPECT_EQ(FindLaw(law.name), &law);
    EXPECT_EQ(FindLaw(law.kind), &law);
    EXPECT_NE(law.make(Omega()), nullptr);
  }
  EXPECT_EQ(FindLaw("no such law"), nullptr);
}

TEST(MaxwellTest, PullsWithTheSpringFromTheTip) {
  auto law = MakeMaxwell(Omega());
  law->Reset(dvec3(0));
  law->BeginTick(dvec3(1e-4, 2e-4, 0));
  const Pull pull = law->PullOn(dvec3(1e-5, 0, 0), Sym3::Isotropic(6500));
  EXPECT_EQ(pull.stiffness_n_per_m, 10e3);
  EXPECT_EQ(pull.stretch_m, dvec3(1e-4 - 1e-5, 2e-4, 0));
}

TEST(PaperTest, OneOmegaCountAtEnamelIsAStepOfFiftyEightNewton) {
  auto law = MakePaperDamping(Omega());
  law->Reset(dvec3(0));
  law->BeginTick(dvec3(9e-6, 0, 0));
  EXPECT_NEAR(law->TipForce(Sym3::Isotropic(6500)).x, 58.5, 1e-9);
}

// Equation 17 as printed, held where it is 0/0: every count adds Kc delta, and nothing is ever
// given back. It is a spring Kc.
TEST(PaperTest, LimiterHeldAtRestIsASpring) {
  auto law = MakePaperLimited(Omega());
  law->Reset(dvec3(0));
  double x = 0, force = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    if (tick % 20 == 0) x += 9e-6;
    law->BeginTick(dvec3(x, 0, 0));
    force = law->TipForce(Sym3::Isotropic(6500)).x;
  }
  EXPECT_NEAR(force, 10e3 * x, 1e-9);
}

TEST(PaperTest, LimiterPassedThroughAtRestGivesNothingOnMostTicks) {
  LawParams p = Omega();
  p.pass_through_at_rest = true;
  auto law = MakePaperLimited(p);
  law->Reset(dvec3(0));
  double x = 0, sum = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    if (tick % 20 == 0) x += 9e-6;
    law->BeginTick(dvec3(x, 0, 0));
    sum += law->TipForce(Sym3::Isotropic(6500)).x;
  }
  // One tick in twenty carries Kc delta = 0.09 N; 2.925 N would be right at this speed.
  EXPECT_NEAR(sum / 2000, 0.09 / 20, 1e-6);
}

// A hand that prescribes velocity, one count every 20 ticks: eq. 12 on both slopes reaches B v and
// stays within a count's Kc delta of it.
TEST(SymmetricTest, FollowsAVelocityHandWithinACountsForce) {
  LawParams p = Omega();
  p.estimator.window_ticks = 256;
  auto law = MakePaperSymmetric(p);
  law->Reset(dvec3(0));
  double force = 0, worst = 0;
  for (int tick = 1; tick < 5000; ++tick) {
    law->BeginTick(dvec3(9e-6 * (tick / 20), 0, 0));
    force = law->TipForce(Sym3::Isotropic(6500)).x;
    if (tick > 2500) worst = std::max(worst, std::fabs(force - 6500 * 0.45e-3));
  }
  EXPECT_LE(worst, 0.25);
  // And it holds for ever when the hand stops: what eq. 12 alone cannot cure.
  for (int tick = 0; tick < 5000; ++tick) {
    law->BeginTick(dvec3(9e-6 * 249, 0, 0));
    force = law->TipForce(Sym3::Isotropic(6500)).x;
  }
  EXPECT_GT(force, 2);
}

TEST(SymmetricTest, NeverChangesByMoreThanKcPerTravelOnAnyAxis) {
  auto law = MakePaperSymmetric(Omega());
  law->Reset(dvec3(0));
  dvec3 tip(0), last(0);
  uint64_t state = 3;
  for (int tick = 0; tick < 5000; ++tick) {
    dvec3 step(0);
    for (int i = 0; i < 3; ++i) {
      state = state * 6364136223846793005ull + 1442695040888963407ull;
      step[i] = 9e-6 * (static_cast<int>(state >> 62) - 1);
    }
    tip += step;
    law->BeginTick(tip);
    dvec3 now = law->TipForce(Sym3::Isotropic(6500));
    for (int i = 0; i < 3; ++i)
      ASSERT_LE(std::fabs(now[i] - last[i]), 10e3 * std::fabs(step[i]) + 1e-12);
    last = now;
  }
}

// Series of spring and tool damper: with the coupling's damper a tenth of Kc T the force of a
// steady hand is still B v.
TEST(VirtualCouplingTest, SettlesAtDampingTimesSpeed) {
  auto law = MakeVirtualCoupling(Omega());
  law->Reset(dvec3(0));
  dvec3 force(0);
  for (int tick = 1; tick < 10000; ++tick) {
    law->BeginTick(dvec3(0.43e-6 * tick, 0, 0));
    force = law->TipForce(Sym3::Isotropic(6500));
  }
  EXPECT_NEAR(force.x, 2.795, 1e-6);
}

// The observer sees energy leave (the tip is pushed on while the force helps it) and the controller
// resists by at most Kc dp.
TEST(PassivityControllerTest, ResistsMoreOnceEnergyWasGivenAway) {
  LawParams p = Omega();
  auto controlled = MakePassivityControlled(p);
  auto plain = MakePaperDamping(p);
  for (auto* law : {controlled.get(), plain.get()}) law->Reset(dvec3(0));
  double x = 0, most = 0;
  for (int tick = 1; tick < 200; ++tick) {
    x += tick % 2 ? 9e-6 : -9e-6;
    double a = 0, b = 0;
    for (auto* law : {controlled.get(), plain.get()}) {
      law->BeginTick(dvec3(x, 0, 0));
      (law == controlled.get() ? a : b) = law->TipForce(Sym3::Isotropic(6500)).x;
    }
    double extra = (a - b) * (tick % 2 ? 1 : -1);
    EXPECT_GE(extra, -1e-12);
    most = std::max(most, extra);
    EXPECT_LE(extra, 10e3 * 9e-6 + 1e-12);
  }
  EXPECT_GT(most, 0);
}

// The bound's own inequality as a property, unquantised: sum R dx + (Kc/2) dx^2 >= 0 whatever eq. 1
// asks for.
TEST(EnergyBoundTest, StoresNoMoreThanItWasGiven) {
  auto law = MakeEnergyBounded(Omega());
  law->Reset(dvec3(0));
  uint64_t state = 11;
  double energy = 0, tip = 0, force = 0;
  for (int tick = 0; tick < 50000; ++tick) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    double dx = (static_cast<double>(state >> 33) / 4294967296.0 - 0.25) * 1e-5;
    energy += force * dx + 0.5 * 10e3 * dx * dx;
    ASSERT_GE(energy, -1e-12) << tick;
    tip += dx;
    law->BeginTick(dvec3(tip, 0, 0));
    force = law->TipForce(Sym3::Isotropic(6500)).x;
  }
}

}  // namespace
}  // namespace enamel::haptics
