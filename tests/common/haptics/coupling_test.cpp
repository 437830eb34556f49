#include "common/haptics/coupling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace enamel::haptics {
namespace {

class UniformMaterial final : public Material {
 public:
  explicit UniformMaterial(Sym3 b) : b_(b) {}
  Contact ContactAt(const dvec3& anchor, const dvec3&) noexcept override {
    Contact c;
    bool inside = anchor.x > surface_x;
    if (inside) c.damping_n_s_per_m = b_;
    c.engaged = inside;
    return c;
  }
  void AnchorMoved(const dvec3& from, const dvec3& to) noexcept override {
    path += glm::length(to - from);
  }
  Sym3 b_;
  double surface_x = -1e9;
  double path = 0;
};

CouplingParams Phantom() {
  CouplingParams p;
  p.law.kc_n_per_m = 2500;
  p.law.resolution_m = dvec3(10e-6);
  p.peak_force_n = 7.9;
  return p;
}

dvec3 Quantise(const dvec3& x, double delta) {
  return dvec3(std::floor(x.x / delta + 0.5), std::floor(x.y / delta + 0.5),
               std::floor(x.z / delta + 0.5)) *
         delta;
}

// Steady state of the Maxwell coupling: R = B V_hand, at any direction. 0.43 mm/s at 6.5 N s/mm is
// 2.795 N; the tolerance is the guard's price, Kc delta / 2 per axis, plus one count's ripple.
TEST(CouplingTest, ConstantSpeedCutSettlesAtDampingTimesSpeed) {
  for (dvec3 direction :
       {dvec3(1, 0, 0), glm::normalize(dvec3(1, 1, 0)), glm::normalize(dvec3(1, 2, 3))}) {
    Coupling coupling(Phantom());
    UniformMaterial enamel(Sym3::Isotropic(6500));
    coupling.Reset(dvec3(0));
    CouplingOutput out;
    for (int tick = 0; tick < 30000; ++tick) {
      out = coupling.Tick(Quantise(direction * (0.43e-6 * tick), 10e-6), 1, enamel);
    }
    EXPECT_NEAR(glm::dot(out.force_sent_n, -direction), 2.795, 2500 * 10e-6 * 1.8);
    EXPECT_EQ(out.flags & kPeakBounded, 0);
  }
}

TEST(CouplingTest, AirCostsNothingAndFirstContactIsFelt) {
  Coupling coupling(Phantom());
  UniformMaterial enamel(Sym3::Isotropic(6500));
  enamel.surface_x = 1e-3;
  coupling.Reset(dvec3(0));
  auto air = coupling.Tick(dvec3(0.5e-3, 0, 0), 1, enamel);
  EXPECT_EQ(air.force_sent_n, dvec3(0));
  EXPECT_TRUE(air.flags & kFreeAir);
  EXPECT_EQ(coupling.anchor_m(), dvec3(0.5e-3, 0, 0));
  // One tick through the surface: the anchor stops there and does not tunnel to the tip.
  auto hit = coupling.Tick(dvec3(2e-3, 0, 0), 1, enamel);
  EXPECT_GT(-hit.force_sent_n.x, 2.0);
  EXPECT_LT(coupling.anchor_m().x, 1.1e-3);
}

TEST(CouplingTest, MagnitudeBoundMovesTheRestPointAndNotTheBur) {
  Coupling coupling(Phantom());
  UniformMaterial stone(Sym3::Isotropic(1e7));
  coupling.Reset(dvec3(0));
  CouplingOutput out;
  for (int tick = 0; tick < 1000; ++tick) out = coupling.Tick(dvec3(tick * 10e-6, 0, 0), 1, stone);
  EXPECT_NEAR(glm::length(out.force_sent_n), 7.9, 1e-9);
  EXPECT_TRUE(out.flags & kPeakBounded);
  EXPECT_NEAR(2500 * (999 * 10e-6 - coupling.rest_m().x), 7.9, 1e-9);
  // 25 N at most pulled for a second through 1e7 N s/m.
  EXPECT_LT(coupling.anchor_m().x, 25 / 1e7);
}

TEST(CouplingTest, NonFiniteInputGivesNoForceAndKeepsTheAnchor) {
  Coupling coupling(Phantom());
  UniformMaterial enamel(Sym3::Isotropic(6500));
  coupling.Reset(dvec3(0));
  coupling.Tick(dvec3(1e-4, 0, 0), 1, enamel);
  dvec3 before = coupling.anchor_m();
  for (double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    auto out = coupling.Tick(dvec3(bad, 0, 0), 1, enamel);
    EXPECT_EQ(out.force_sent_n, dvec3(0));
    EXPECT_TRUE(out.flags & kNonFiniteInput);
  }
  EXPECT_EQ(coupling.anchor_m(), before);
}

TEST(CouplingTest, WhatWasNotFiniteLatchesUntilReset) {
  UniformMaterial enamel(Sym3::Isotropic(6500)), broken(Sym3{std::nan(""), 0, 0, 0, 0, 0});
  for (const LawEntry& law : ForceLaws()) {
    for (bool position : {true, false}) {
      CouplingParams params = Phantom();
      params.law.kind = law.kind;
      Coupling coupling(params);
      coupling.Reset(dvec3(0));
      dvec3 bad = position ? dvec3(std::nan(""), 0, 0) : dvec3(1e-5, 0, 0);
      auto out = coupling.Tick(bad, 1, position ? enamel : broken);
      EXPECT_TRUE(out.flags & kLatched) << law.name;
      EXPECT_EQ(out.force_sent_n, dvec3(0)) << law.name;
      for (int tick = 1; tick < 100; ++tick) {
        out = coupling.Tick(dvec3(1e-5 * tick, 0, 0), 1, enamel);
        EXPECT_EQ(out.force_sent_n, dvec3(0)) << law.name;
        EXPECT_TRUE(out.flags & kLatched) << law.name;
      }
      EXPECT_FALSE(coupling.Resume(dvec3(1e-3, 0, 0), enamel)) << law.name;
      coupling.Reset(dvec3(1e-3, 0, 0));
      for (int tick = 1; tick < 100; ++tick)
        out = coupling.Tick(dvec3(1e-3 + 1e-5 * tick, 0, 0), 1, enamel);
      EXPECT_FALSE(out.flags & kLatched) << law.name;
      EXPECT_NE(out.force_sent_n, dvec3(0)) << law.name;
    }
  }
}

TEST(CouplingTest, NonFiniteMaterialGivesNoMotionOfTheAnchor) {
  Coupling coupling(Phantom());
  UniformMaterial broken(Sym3{std::nan(""), 0, 0, 0, 0, 0});
  coupling.Reset(dvec3(0));
  auto out = coupling.Tick(dvec3(1e-5, 0, 0), 1, broken);
  EXPECT_EQ(out.force_sent_n, dvec3(0));
  EXPECT_EQ(coupling.anchor_m(), dvec3(0));
}

class RandomMaterial final : public Material {
 public:
  explicit RandomMaterial(uint64_t seed) : random_(seed) {}
  Contact ContactAt(const dvec3&, const dvec3&) noexcept override {
    Contact c;
    int rank = static_cast<int>(random_() % 4);
    for (int i = 0; i < rank; ++i) {
      dvec3 n(normal_(random_), normal_(random_), normal_(random_));
      c.damping_n_s_per_m += Sym3::Outer(n, std::exp(normal_(random_) * 3 + 5));
    }
    c.engaged = rank > 0;
    return c;
  }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

// The theorem of coupling.h as a property: with Kc = 2 b/T and c = Kc delta / 2 per axis, the sum
// of R.dx + (b/T) dx.dx + c sum |dx_i| never falls below -V_0 = 0 from an unloaded start, whatever
// B does each tick and wherever the true position is in its encoder cell. It holds whatever friction the
// law leaves out: every second hand plays against four times c.
class PassivityTest : public testing::TestWithParam<LawKind> {};

TEST_P(PassivityTest, OperatorNeverExtractsEnergy) {
  CouplingParams params = Phantom();
  params.law.kind = GetParam();
  params.peak_force_n = 5;
  const double delta = 10e-6, kc = params.law.kc_n_per_m, b_over_t = kc / 2, c = kc * delta / 2;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    // All of it in every tissue, and without a push: c is not what there is.
    params.friction = {dvec3(seed % 2 == 0 ? 4 * c : 0), false, 1e9};
    Coupling coupling(params);
    RandomMaterial material(seed);
    dvec3 x(0), v(0), force(0);
    coupling.Reset(x);
    double energy = 0;
    double step = delta * std::pow(10.0, static_cast<double>(seed % 5) - 2);
    for (int tick = 0; tick < 5000; ++tick) {
      v = v * 0.9 + dvec3(normal(random), normal(random), normal(random)) * step;
      dvec3 dx = v;
      energy += glm::dot(-force, dx) + b_over_t * glm::dot(dx, dx) +
                c * (std::fabs(dx.x) + std::fabs(dx.y) + std::fabs(dx.z));
      ASSERT_GE(energy, -1e-12) << "seed " << seed << " tick " << tick;
      x += dx;
      force = coupling.Tick(Quantise(x, delta), 1, material).force_sent_n;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(AnchoredLaws, PassivityTest,
                         testing::Values(LawKind::kMaxwell, LawKind::kLeadMaxwell),
                         [](const auto& i) {
                           return i.param == LawKind::kMaxwell ? "Maxwell" : "LeadMaxwell";
                         });

// The same with everything the chain may do besides: still-bur walls, a bound that rises and falls,
// gaps resumed or not.
class ChangingMaterial final : public Material {
 public:
  explicit ChangingMaterial(uint64_t seed) : random_(seed) {}
  Contact ContactAt(const dvec3&, const dvec3& stretch) noexcept override {
    Contact c;
    if (still) {
      dvec3 n = glm::normalize(dvec3(1, 0.3, -0.2));
      if (glm::dot(n, stretch) > 0) c.wall_normal = n;
    } else if (random_() % 3) {
      c.damping_n_s_per_m = Sym3::Isotropic(std::exp(normal_(random_) * 3 + 5));
    }
    c.engaged = true;
    return c;
  }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}
  bool still = false;

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

TEST(CouplingTest, OperatorNeverExtractsEnergyAtWallsUnderChangingBoundsAndGaps) {
  CouplingParams params = Phantom();
  params.peak_force_n = 3;
  const double delta = 10e-6, kc = params.law.kc_n_per_m, b_over_t = kc / 2, c = kc * delta / 2;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    params.friction = {dvec3(seed % 2 == 0 ? 4 * c : 0), false, seed % 4 == 0 ? 0.16 : 1e9};
    Coupling coupling(params);
    ChangingMaterial material(seed);
    dvec3 x(0), v(0), force(0);
    coupling.Reset(x);
    double energy = 0, bound = 0;
    double step = delta * std::pow(10.0, static_cast<double>(seed % 4) - 1.5);
    for (int tick = 0; tick < 8000; ++tick) {
      if (random() % 500 == 0) material.still = !material.still;
      bound = random() % 700 == 0 ? 0 : std::min(1.0, bound + 0.002);
      v = v * 0.95 + dvec3(normal(random), normal(random), normal(random)) * step;
      energy += glm::dot(-force, v) + b_over_t * glm::dot(v, v) +
                c * (std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z));
      ASSERT_GE(energy, -1e-12) << "seed " << seed << " tick " << tick;
      x += v;
      dvec3 tip = Quantise(x, delta);
      if (random() % 400 == 0) {
        force = dvec3(0);
        // The spring may be as long as before, to within the encoder's cell on both readings.
        double slack = kc * delta * 2 * glm::length(tip - coupling.anchor_m());
        if (!coupling.Resume(tip, material)) coupling.Reset(tip);
        energy += slack + kc * delta * delta * 3;
      } else {
        force = coupling.Tick(tip, bound, material).force_sent_n;
      }
    }
  }
}

// The premise of the proof, checked on the moves themselves: no anchor move, once guarded,
// lengthens the spring for any true position within the encoder cell.
TEST(GuardTest, NoGuardedMoveRaisesSpringEnergyAnywhereInTheCell) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  dvec3 delta(10e-6, 20e-6, 9e-6);
  for (int i = 0; i < 20000; ++i) {
    dvec3 e = dvec3(normal(random), normal(random), normal(random)) * 1e-5;
    dvec3 w = dvec3(normal(random), normal(random), normal(random)) * 1e-5;
    const GuardParams guard{.kc_n_per_m = 1000, .cell = CartesianCell(delta)};
    Tank none;
    w *= GuardedStep(guard, e, w, 0, none);
    for (int corner = 0; corner < 8; ++corner) {
      dvec3 x = e + dvec3(corner & 1 ? delta.x : -delta.x, corner & 2 ? delta.y : -delta.y,
                          corner & 4 ? delta.z : -delta.z) *
                        0.5;
      EXPECT_LE(glm::dot(x - w, x - w), glm::dot(x, x) * (1 + 1e-12) + 1e-24);
    }
  }
}

// The bur cuts as it does without, and the force sent lacks what is left out. At a wall all of a guess stays.
TEST(OwnFrictionTest, ChangesTheForceAndNotTheCut) {
  CouplingParams with = Phantom();
  with.friction.c_n = dvec3(0.3, 0, 0);
  Coupling less(with), plain(Phantom());
  UniformMaterial same(Sym3::Isotropic(6500)), enamel(Sym3::Isotropic(6500));
  less.Reset(dvec3(0));
  plain.Reset(dvec3(0));
  CouplingOutput a, b;
  for (int tick = 0; tick < 30000; ++tick) {
    const dvec3 tip = Quantise(dvec3(0.43e-6 * tick, 0, 0), 10e-6);
    a = less.Tick(tip, 1, same);
    b = plain.Tick(tip, 1, enamel);
    ASSERT_EQ(a.anchor_m, b.anchor_m) << tick;
  }
  const double left_out = 1 - LessFriction(dvec3(1, 0, 0), 6500, 2500, with.friction).x;
  EXPECT_NEAR(a.force_sent_n.x - b.force_sent_n.x, left_out, 2500 * 10e-6);

  Coupling guessed(with);
  ChangingMaterial wall(1);
  wall.still = true;
  guessed.Reset(dvec3(0));
  const dvec3 into(1e-3, 0.3e-3, -0.2e-3);
  EXPECT_NEAR(glm::length(guessed.Tick(into, 1, wall).force_sent_n), 2500 * glm::length(into),
              2500 * 10e-6);
}

TEST(CouplingTest, SoftStartScalesTheBound) {
  Coupling coupling(Phantom());
  UniformMaterial stone(Sym3::Isotropic(1e7));
  coupling.Reset(dvec3(0));
  auto out = coupling.Tick(dvec3(3e-3, 0, 0), 0.25, stone);
  EXPECT_NEAR(glm::length(out.force_sent_n), 0.25 * 7.9, 1e-9);
}

}  // namespace
}  // namespace enamel::haptics
