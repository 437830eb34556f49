#include <gtest/gtest.h>

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
  EXPECT_EQ(ForceLaws().size(), 4u);
  for (const LawEntry& law : ForceLaws()) {
    EXPECT_EQ(FindLaw(law.name), &law);
    EXPECT_EQ(FindLaw(law.kind), &law);
    EXPECT_NE(law.make(Omega()), nullptr);
  }
  EXPECT_EQ(FindLaw("no such law"), nullptr);
}

// Closed form of the implicit step in one dimension: e' = e / (1 + Kc T / B).
TEST(MaxwellTest, RelaxesAsTheImplicitClosedForm) {
  auto law = MakeMaxwell(Omega());
  for (double b : {1.0, 6500.0, 1e6}) {
    dvec3 e = law->Relax(dvec3(1e-4, 0, 0), Sym3::Isotropic(b), 1e-3);
    EXPECT_NEAR(e.x, 1e-4 / (1 + 10e3 * 1e-3 / b), 1e-18);
    EXPECT_EQ(e.y, 0);
  }
}

TEST(MaxwellTest, AirFollowsAtOnceAndAWallHolds) {
  auto law = MakeMaxwell(Omega());
  EXPECT_EQ(law->Relax(dvec3(1e-4, 2e-4, 0), Sym3{}, 1e-3), dvec3(0));
  dvec3 held = law->Relax(dvec3(1e-4, 0, 0), Sym3::Isotropic(1e15), 1e-3);
  EXPECT_NEAR(held.x, 1e-4, 1e-15);
}

// Only the damped direction resists: B = b n n^T leaves nothing across n.
TEST(MaxwellTest, SingularMatrixSlidesFreelyAcrossItsNormal) {
  auto law = MakeMaxwell(Omega());
  dvec3 n = glm::normalize(dvec3(1, 1, 0));
  dvec3 e = law->Relax(dvec3(1e-4, 0, 0), Sym3::Outer(n, 6500), 1e-3);
  EXPECT_LT(glm::length(e - n * glm::dot(e, n)), 1e-18);
  EXPECT_NEAR(glm::dot(e, n), 1e-4 * std::sqrt(0.5) / (1 + 10.0 / 6500), 1e-15);
}

TEST(PaperTest, OneOmegaCountAtEnamelIsAStepOfFiftyEightNewton) {
  auto law = MakePaperDamping(Omega());
  law->Reset(dvec3(0));
  law->BeginTick(dvec3(9e-6, 0, 0));
  EXPECT_NEAR(law->TipForce(Sym3::Isotropic(6500)).x, 58.5, 1e-9);
}

// Equation 17 as printed, held where it is 0/0: every count adds Kc delta, nothing is ever given
// back, so it is a spring Kc.
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

}  // namespace
}  // namespace enamel::haptics
