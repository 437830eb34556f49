#include "common/haptics/friction_relief.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/haptics/coupling.h"
#include "common/haptics/uniform_material.h"

namespace enamel::haptics {
namespace {

constexpr double kKc_n_per_m = 10e3, kRadius_m = 5e-6;
const OwnFriction kMeasured{dvec3(0.09), true}, kGuess{dvec3(0.09), false};

FrictionRelief Relief(const OwnFriction& own, bool soften = true) {
  return {own, kKc_n_per_m, 1e-3, kRadius_m, soften};
}

TEST(FrictionReliefTest, FrictionIsLeftOutOfEachAxisAndTurnsNoForceAround) {
  const dvec3 asked =
      LessFriction(dvec3(0.5, -0.15, -0.3), 0, kKc_n_per_m, {dvec3(0.1, 0.2, 0), true});
  EXPECT_NEAR(asked.x, 0.4, 1e-15);
  EXPECT_EQ(asked.y, 0);
  EXPECT_EQ(asked.z, -0.3);
  EXPECT_EQ(LessFriction(dvec3(1, 2, 3), 6500, kKc_n_per_m, OwnFriction{}), dvec3(1, 2, 3));
}

// No step of R makes a longer step of S, also where R changes sign: nothing there can chatter.
TEST(FrictionReliefTest, ForceAskedNeverMovesMoreThanThePull) {
  double before = LessFriction(dvec3(-0.3, 0, 0), 530, kKc_n_per_m, kGuess).x;
  for (double r = -0.299; r < 0.3; r += 0.001) {
    const double asked = LessFriction(dvec3(r, 0, 0), 530, kKc_n_per_m, kGuess).x;
    EXPECT_GE(asked, before);
    EXPECT_LE(asked - before, 0.001 + 1e-12);
    EXPECT_GE(asked * r, 0);
    before = asked;
  }
}

TEST(FrictionReliefTest, LessIsLeftOutTheHarderTheTissueAndLeastOfAGuess) {
  for (const auto& [own, half_s] : {std::pair{kGuess, 0.04}, {kMeasured, 1.0}}) {
    const auto left_out = [friction = own](double b) {
      return 1 - LessFriction(dvec3(1, 0, 0), b, kKc_n_per_m, friction).x;
    };
    const double half = half_s * kKc_n_per_m;
    EXPECT_NEAR(left_out(0), 0.09, 1e-15);
    EXPECT_NEAR(left_out(half), 0.045, 1e-15);
    EXPECT_NEAR(left_out(6500), 0.09 * half / (half + 6500), 1e-15);
    EXPECT_EQ(left_out(std::numeric_limits<double>::infinity()), 0);
  }
}

// What the proof needs of a push, of any pull, in any order: with the cell of the spring it is never more than c.
TEST(FrictionReliefTest, APushIsNeverMoreThanTheCellLeavesOfTheFriction) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> pull(0, 0.1);
  std::uniform_real_distribution<double> share(0, 1.5);
  for (const dvec3& c : {dvec3(0.09), dvec3(0.09, 0.2, 0.05), dvec3(0.09, 0, 0.3)}) {
    FrictionRelief relief = Relief({c, true});
    const double least = std::min({c.x, c.y, c.z});
    for (int i = 0; i < 20'000; ++i) {
      const double kc = share(random) * kKc_n_per_m, b = i % 7 == 0 ? 0 : 1e4 * share(random);
      const dvec3 push = relief.Push({pull(random), pull(random), pull(random)}, b, kc);
      ASSERT_LE(glm::length(push), std::max(0.0, least - kc * kRadius_m) + 1e-15);
    }
  }
}

// Held for long enough, motors and friction together resist as the tissue does: R, as far as friction is spare.
TEST(FrictionReliefTest, APushMakesUpForTheFrictionThatIsMoreThanTheTissues) {
  const auto push = [](double r_n, double kc, const OwnFriction& own = kMeasured) {
    FrictionRelief relief = Relief(own);
    dvec3 out(0);
    for (int i = 0; i < 200; ++i) out = relief.Push({r_n, 0, 0}, 100, kc);
    return out;
  };
  const double told = 0.09 / 1.01;  // B/Kc of 10 ms in 1 s
  EXPECT_NEAR(push(0.05, 1e3).x, told - 0.05, 1e-9);
  EXPECT_NEAR(push(-0.05, 1e3).x, 0.05 - told, 1e-9);
  EXPECT_EQ(push(0.05, 1e3).y, 0);
  EXPECT_EQ(push(0.1, 1e3), dvec3(0)) << "the motors resist";
  EXPECT_NEAR(push(0.05, 15e3).x, 0.09 - 15e3 * kRadius_m, 1e-12) << "the cell is paid first";
  EXPECT_EQ(push(0.05, 20e3), dvec3(0));
  EXPECT_EQ(push(0.05, 1e3, kGuess), dvec3(0)) << "a guess pushes nobody";
  EXPECT_LT(push(0.001, 1e3).x, 0.3 * told) << "a count's force is no direction";
}

TEST(FrictionReliefTest, APushForgetsWhereTheTipWent) {
  FrictionRelief relief = Relief(kMeasured);
  for (int i = 0; i < 100; ++i) relief.Push({0.05, 0, 0}, 100, 1e3);
  relief.Forget();
  EXPECT_EQ(relief.Push(dvec3(0), 100, 1e3), dvec3(0));
}

// The tank pays for all that a rise may add to a spring, whose tip may be anywhere in its cell.
TEST(FrictionReliefTest, ARiseCostsTheTankWhatItAddsToTheSpring) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  FrictionRelief relief = Relief(kMeasured);
  for (int i = 0; i < 20'000; ++i) {
    EnTank tank{};
    tank.energy_j = i % 3 == 0 ? 0 : 1e-7 * unit(random);
    const double before = relief.share(), had_j = tank.energy_j;
    const double stretch = 1e-4 * unit(random), b = i % 5 == 0 ? 0 : 2e3 * unit(random);
    relief.TakeShare(relief.NextShare(b), stretch, &tank);
    const double after = relief.share();
    ASSERT_GE(tank.energy_j, 0);
    ASSERT_LE(tank.energy_j, had_j);
    const double reach = stretch + kRadius_m;
    const double added_j = 0.5 * (after - before) * kKc_n_per_m * reach * reach;
    ASSERT_LE(added_j, had_j - tank.energy_j + 1e-18);
    ASSERT_GE(after, kMinSoftness);
    ASSERT_LE(after, 1);
  }
}

TEST(FrictionReliefTest, TheSpringIsAsStiffAsTheTissueNeeds) {
  EnTank full{};
  full.energy_j = 1;
  const auto settled = [&](FrictionRelief relief, double b) {
    for (int i = 0; i < 500; ++i) relief.TakeShare(relief.NextShare(b), 1e-5, &full);
    return relief.share();
  };
  EXPECT_NEAR(settled(Relief(kMeasured), 250), 250 / (kSoftest_s * kKc_n_per_m), 1e-9);
  EXPECT_NEAR(settled(Relief(kMeasured), 1), kMinSoftness, 1e-9);
  for (double b : {0.0, 500.0, 1e5, std::numeric_limits<double>::infinity()})
    EXPECT_NEAR(settled(Relief(kMeasured), b), 1, 1e-9) << b;
  EXPECT_EQ(settled(Relief(kMeasured, false), 100), 1) << "forces are under way, or a board has it";
  EXPECT_EQ(settled(Relief(kGuess), 100), 1);
  FrictionRelief relief = Relief(kMeasured);
  relief.TakeShare(relief.NextShare(100), 0, &full);
  EXPECT_LT(relief.share(), 1);
  relief.Reset();
  EXPECT_EQ(relief.share(), 1);
}

// Tick by tick, with the true tip: what the hand draws in a motion leaves the spring and is paid by damping and
// friction, and within a tick spring and tank together gain nothing. The reading is anywhere in the cell.
void ExpectNothingGained(uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> normal;
  const double cell_m = seed % 3 == 0 ? 1e-8 : seed % 3 == 1 ? 9e-6 : 30e-6;
  CouplingParams p;
  p.law = {kDefaultLaw, kKc_n_per_m, dvec3(cell_m), 1e-3};
  p.peak_force_n = seed % 5 == 0 ? 2 : 12;
  p.watch_swings = seed % 7 == 0;
  const TipCell cell = CartesianCell(dvec3(cell_m));
  const double c_n = kKc_n_per_m * cell.Radius() * (seed % 2 == 0 ? 1 : 1.5);
  p.friction = {dvec3(c_n), true};
  Coupling coupling(p);
  UniformMaterial tissue(Sym3::Isotropic(0));
  dvec3 x(0), force_n(0);
  const auto reading = [&] {
    return x + dvec3(unit(random), unit(random), unit(random)) * cell.half_m;
  };
  const auto spring_j = [&](double k) {
    const dvec3 e = x - coupling.rest_m();
    return 0.5 * k * Dot(e, e);
  };
  coupling.Reset(reading());
  double k = coupling.stiffness_n_per_m(), bound = 1;
  dvec3 way(0);
  for (int tick = 0, turn = 0, kind = 0; tick < 2000; ++tick) {
    if (--turn < 0) {
      turn = 1 + static_cast<int>(random() % 40);
      kind = static_cast<int>(random() % 5);
      const double kinds[] = {0, 5, 30, 100, 200, 400, 2000, 1e4, 1e9};
      tissue = UniformMaterial(Sym3::Isotropic(kinds[random() % 9]));
      if (random() % 4 == 0) bound = random() % 2 == 0 ? 1 : std::fabs(unit(random));
      way = dvec3(normal(random), normal(random), normal(random)) *
            (5e-6 * std::pow(10, 1.2 * unit(random)));
    }
    const dvec3 e = x - coupling.rest_m();
    const dvec3 moved = kind == 0 ? e * 0.1 : kind == 1 ? e * -0.15 : kind == 2 ? dvec3(0) : way;
    const double before_j = spring_j(k);
    x += moved;
    const double paid_j = 0.5 * kKc_n_per_m * Dot(moved, moved) +
                          c_n * (std::fabs(moved.x) + std::fabs(moved.y) + std::fabs(moved.z));
    ASSERT_GE(-Dot(force_n, moved) + paid_j, spring_j(k) - before_j - 1e-15)
        << seed << ", " << tick;
    const double had_j = spring_j(k) + coupling.tank_j();
    const double k_before = k;
    force_n = coupling.Tick(reading(), bound, tissue).force_sent_n;
    k = coupling.stiffness_n_per_m();
    ASSERT_LE(spring_j(k) + coupling.tank_j(), had_j + 1e-15)
        << seed << ", " << k_before << " to " << k;
  }
}

TEST(FrictionReliefTest, NeitherAMotionNorATickGainsEnergy) {
  for (uint64_t seed = 1; seed <= 100; ++seed) ExpectNothingGained(seed);
}

// From soft tissue against what does not give, with nothing in the tank: the spring becomes stiff at once.
TEST(FrictionReliefTest, ASoftSpringThatMeetsAWallBecomesStiff) {
  CouplingParams p;
  p.law = {kDefaultLaw, kKc_n_per_m, dvec3(1e-6), 1e-3};
  p.peak_force_n = 12;
  p.friction = {dvec3(0.09), true};
  Coupling coupling(p);
  UniformMaterial tissue(Sym3::Isotropic(100));
  coupling.Reset(dvec3(0));
  double x_m = 0;
  const auto go = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) coupling.Tick({x_m += 1e-6, 0, 0}, 1, tissue);
    return coupling.stiffness_n_per_m() / kKc_n_per_m;
  };
  EXPECT_NEAR(go(200), 100 / (kSoftest_s * kKc_n_per_m), 0.05);
  tissue = UniformMaterial(Sym3::Isotropic(1e9));
  EXPECT_GT(go(100), 0.95);
}

}  // namespace
}  // namespace enamel::haptics
