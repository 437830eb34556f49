#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "common/haptics/coupling.h"
#include "common/haptics/uniform_material.h"

namespace enamel::haptics {
namespace {

constexpr double kKc = 10e3, kCell_m = 9e-6, kTick_s = 1e-3;
const double kUnit_s = std::sqrt(0.6 / kKc);

LawParams Omega() {
  LawParams p{LawKind::kLeadMaxwell, kKc, dvec3(kCell_m), kTick_s};
  p.play_m = std::sqrt(3.0) * kCell_m;
  return p;
}

CouplingParams OmegaCoupling(LawKind kind = LawKind::kLeadMaxwell) {
  CouplingParams p;
  p.law = {kind, kKc, dvec3(kCell_m), kTick_s};
  p.peak_force_n = 12;
  return p;
}

dvec3 Middle(const dvec3& x) { return (glm::floor(x / kCell_m) + 0.5) * kCell_m; }

// The tip jumps to `tip_m` and stays; the bur stays at 0. The pull after `ticks`.
Pull Held(double tip_m, double b, int ticks) {
  auto law = MakeLeadMaxwell(Omega());
  law->Reset(dvec3(0));
  Pull pull;
  for (int i = 0; i < ticks; ++i) {
    law->BeginTick(dvec3(tip_m, 0, 0));
    pull = law->PullOn(dvec3(0), Sym3::Isotropic(b));
  }
  return pull;
}

// n = sqrt(B / (6 sqrt(0.6 kg Kc))), at most 3.8, and falls to 1 beyond 34 N s/mm. A metre is so many
// cells that n is whole, and long enough a wait that the slow tip is there.
TEST(LeadMaxwellTest, StiffnessForSlowMotionIsTheClosedForm) {
  const double from = 6 * std::sqrt(0.6 * kKc);
  for (double b : {300.0, 1000.0, 3000.0, 6500.0, 20e3, 34e3, 100e3}) {
    double n = b < from ? 1 : std::min(std::sqrt(b / from), 3.8);
    n = 1 + (n - 1) / (1 + b * b / (34e3 * 34e3));
    const Pull pull = Held(1, b, 4000);
    EXPECT_NEAR(pull.stiffness_n_per_m, n * kKc, 1e-3 * kKc) << b;
    EXPECT_NEAR(pull.stretch_m.x, 1, 1e-6) << b;
  }
}

// Half of n - 1 where the slow tip is ten cells from the bur.
TEST(LeadMaxwellTest, AForceOfAFewCountsIsNotLed) {
  const double whole = Held(1, 6500, 4000).stiffness_n_per_m;
  EXPECT_NEAR(Held(10 * kCell_m, 6500, 4000).stiffness_n_per_m, (kKc + whole) / 2, 0.002 * kKc);
  EXPECT_LT(Held(kCell_m, 6500, 4000).stiffness_n_per_m, 1.03 * kKc);
}

// R/Kc of a tip that is held at 1 m: half of the spring (n > 2) gives way within 0.8 units, the other
// half within the 20 in which n (x - a) comes up. Backward Euler: each has 1/(1 + T/tau) a tick. In the
// first tick the slow tip is still at the bur, and the spring is plain.
TEST(LeadMaxwellTest, ShockIsAbsorbedAndTheLeadComesUpAsTheClosedForm) {
  const double b = 6500, n = Held(1, b, 4000).stiffness_n_per_m / kKc;
  const double shock = 1 / (1 + kTick_s / (0.8 * kUnit_s)),
               lead = 1 / (1 + kTick_s / (20 * kUnit_s));
  for (int ticks : {3, 10, 40, 200, 1000}) {
    const Pull pull = Held(1, b, ticks);
    const double quick = std::pow(shock, ticks), slow = std::pow(lead, ticks);
    const double expected = 0.5 * quick + 0.5 * slow + n * (1 - slow);
    EXPECT_NEAR(pull.stretch_m.x * pull.stiffness_n_per_m / kKc, expected, 2e-4) << ticks;
  }
}

// The lead's time is at most 0.3 B/Kc, or soft tissue would be felt later than with the plain spring.
TEST(LeadMaxwellTest, InSoftTissueTheLeadIsAsQuickAsTheTissue) {
  const double b = 1000, n = Held(1, b, 4000).stiffness_n_per_m / kKc;
  const double lead = 1 / (1 + kTick_s / (0.3 * b / kKc)),
               shock = 1 / (1 + kTick_s / (0.8 * kUnit_s));
  const double share = 0.5 * (n - 1);
  for (int ticks : {3, 5, 30, 100}) {
    const Pull pull = Held(1, b, ticks);
    const double expected = share * std::pow(shock, ticks) + (1 - share) * std::pow(lead, ticks) +
                            n * (1 - std::pow(lead, ticks));
    EXPECT_NEAR(pull.stretch_m.x * pull.stiffness_n_per_m / kKc, expected, 2e-4) << ticks;
  }
}

// Half of the shock's share where the slow tip is three cells from the bur.
TEST(LeadMaxwellTest, ShocksOfAFewCountsAreNotAbsorbed) {
  auto Share = [](double tip_m) {
    auto law = MakeLeadMaxwell(Omega());
    law->Reset(dvec3(0));
    for (int i = 0; i < 4000; ++i) {
      law->BeginTick(dvec3(tip_m, 0, 0));
      law->PullOn(dvec3(0), Sym3::Isotropic(6500));
    }
    // A step of a tenth of a cell: Kc at once, less what a tick of the absorber takes.
    const double step = 0.1 * kCell_m;
    law->BeginTick(dvec3(tip_m + step, 0, 0));
    const Pull before = Held(tip_m, 6500, 4000),
               after = law->PullOn(dvec3(0), Sym3::Isotropic(6500));
    const double risen =
        after.stretch_m.x * after.stiffness_n_per_m - before.stretch_m.x * before.stiffness_n_per_m;
    const double quick = 1 / (1 + kTick_s / (0.8 * kUnit_s)),
                 slow = 1 / (1 + kTick_s / (20 * kUnit_s));
    const double n = after.stiffness_n_per_m / kKc;
    return (slow + n * (1 - slow) - risen / (kKc * step)) / (slow - quick);
  };
  EXPECT_NEAR(Share(3 * kCell_m), 0.25, 0.01);
  EXPECT_NEAR(Share(1000 * kCell_m), 0.5, 0.01);
}

// Whatever a tip and a bur do, 0 <= s.(e - s): the stretch s is in the ball with diameter a..p.
TEST(LeadMaxwellTest, ThePullIsTowardTheTipAndNotPastIt) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  auto law = MakeLeadMaxwell(Omega());
  dvec3 tip(0), anchor(0);
  law->Reset(tip);
  for (int i = 0; i < 100000; ++i) {
    const double pace = kCell_m * std::pow(10.0, i / 5000 % 5 - 2);
    tip += dvec3(normal(random), normal(random), normal(random)) * pace;
    const Sym3 b = i % 7 == 0 ? Sym3::Outer(dvec3(0.6, 0.8, 0), 6500)
                              : Sym3::Isotropic(std::exp(2 * normal(random) + 7));
    law->BeginTick(tip);
    const Pull pull = law->PullOn(anchor, b);
    const dvec3 e = tip - anchor, s = pull.stretch_m;
    ASSERT_LE(Dot(s, s - e), 1e-9 * Dot(e, e)) << i;
    anchor += s * 0.02;
    if (i % 1000 == 0) law->PassAir();
  }
}

// A cut of 2.8 N, then a lift: the force falls at least in proportion to the tip's distance from the
// bur, and is 0 where they meet, though the slow tip lies far ahead by then.
TEST(LeadMaxwellTest, OnTheWayBackTheForceFallsToNoneWhereTipMeetsBur) {
  Coupling coupling(OmegaCoupling());
  UniformMaterial enamel(Sym3::Isotropic(6500));
  coupling.Reset(Middle(dvec3(0)));
  double x = 0;
  CouplingOutput out;
  for (int tick = 0; tick < 4000; ++tick)
    out = coupling.Tick(Middle(dvec3(x += 0.43e-6, 0, 0)), 1, enamel);
  const double from_n = -out.force_sent_n.x, from_m = x - out.anchor_m.x;
  ASSERT_NEAR(from_n, 2.795, 0.1);
  while (x > out.anchor_m.x + kCell_m) {
    out = coupling.Tick(Middle(dvec3(x -= 20e-6, 0, 0)), 1, enamel);
    // A play of 1.73 cells passes before a way back is one, and a reading is off by half a cell.
    const double allowed = from_n * (x - out.anchor_m.x) / from_m + 3 * kCell_m * kKc;
    EXPECT_LE(-out.force_sent_n.x, allowed);
    EXPECT_GE(-out.force_sent_n.x, -kKc * kCell_m);
  }
}

// What the tip does across a wall of tissue is free: no lag, no force.
TEST(LeadMaxwellTest, NothingLagsWhereNothingResists) {
  Coupling coupling(OmegaCoupling());
  UniformMaterial side(Sym3::Outer(dvec3(1, 0, 0), 6500));
  coupling.Reset(Middle(dvec3(0)));
  CouplingOutput out;
  for (int tick = 0; tick < 2000; ++tick)
    out = coupling.Tick(Middle(dvec3(0.43e-6 * tick, 0, 50e-6 * tick)), 1, side);
  EXPECT_NEAR(-out.force_sent_n.x, 2.795, 0.15);
  EXPECT_LE(std::fabs(out.force_sent_n.z), kKc * kCell_m / 2);
  EXPECT_NEAR(out.anchor_m.z, Middle(dvec3(0, 0, 50e-6 * 1999)).z, kCell_m);
}

// The worst of 24 turned lattices, rounded again by the driver to cells of the same edge.
TEST(LeadMaxwellTest, ASteadyCutHoldsOnPositionsThatADriverRounds) {
  for (int turn = 0; turn < 24; ++turn) {
    const double a = 0.37 * turn, c = 0.61 * turn;
    const dvec3 x(std::cos(a) * std::cos(c), std::sin(a) * std::cos(c), std::sin(c));
    const dvec3 y = glm::normalize(glm::cross(dvec3(0.3, -0.2, 1), x)), z = glm::cross(x, y);
    const glm::dmat3 to_space(x, y, z);
    CouplingParams params = OmegaCoupling();
    params.cell = LatticeCell(kCell_m, kCell_m);
    Coupling coupling(params);
    UniformMaterial enamel(Sym3::Isotropic(6500));
    const dvec3 way = turn % 3 == 0 ? dvec3(1, 0, 0) : glm::normalize(dvec3(1, 0.1 * turn, -0.5));
    auto Read = [&](double s) {
      const dvec3 joints = glm::transpose(to_space) * (way * s + dvec3(3.3e-6, 2.1e-6, 1.1e-6));
      return glm::floor(to_space * Middle(joints) / kCell_m + 0.5) * kCell_m;
    };
    coupling.Reset(Read(0));
    double squares = 0, least = 1e9;
    constexpr int kSettled = 5000, kTicks = 7000;
    for (int tick = 0; tick < kTicks; ++tick) {
      const dvec3 r = -coupling.Tick(Read(0.43e-6 * tick), 1, enamel).force_sent_n;
      if (tick < kSettled) continue;
      const dvec3 off = r - way * 2.795;
      squares += Dot(off, off);
      least = std::min(least, Dot(r, way));
    }
    EXPECT_LT(std::sqrt(squares / (kTicks - kSettled)), 0.1) << turn;
    EXPECT_GT(least, 0.9 * 2.795) << turn;
  }
}

// At first contact the spring is the plain one: no law may pass inside a wall without force.
TEST(LeadMaxwellTest, FirstContactIsFeltAsSoonAsWithThePlainSpring) {
  class Half final : public Material {
   public:
    Contact ContactAt(const dvec3& anchor, const dvec3& stretch) noexcept override {
      Contact c;
      if (anchor.x < 0) {
        c.clearance_m = std::max(-anchor.x, 1e-9);
      } else if (stretch.x > 0) {
        c.damping_n_s_per_m = Sym3::Isotropic(6500);
        c.engaged = true;
      }
      return c;
    }
    void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}
  };
  for (double speed : {2e-3, 10e-3, 50e-3}) {
    auto Way = [&](LawKind kind) {
      Coupling coupling(OmegaCoupling(kind));
      Half half;
      double x = -1e-3;
      coupling.Reset(Middle(dvec3(x, 0, 0)));
      CouplingOutput out;
      while (-out.force_sent_n.x < 0.1) {
        out = coupling.Tick(Middle(dvec3(x += speed * kTick_s, 0, 0)), 1, half);
        if (x < 0)
          EXPECT_NEAR(out.anchor_m.x, Middle(dvec3(x, 0, 0)).x, 1e-15)
              << "the bur is behind the tip in air";
      }
      return x;
    };
    EXPECT_LE(Way(LawKind::kLeadMaxwell), Way(LawKind::kMaxwell) + kCell_m) << speed;
  }
}

// A reading after Resume may be stepped at once, in the same tick of the device: what the tip does from
// then on is paid, and the tank pays for what was left of the spring.
TEST(LeadMaxwellTest, TheTickAfterAGapGivesForceAndIsPaid) {
  UniformMaterial enamel(Sym3::Isotropic(6500));
  Coupling coupling(OmegaCoupling());
  coupling.Reset(Middle(dvec3(0)));
  CouplingOutput out;
  double x = 0;
  for (int tick = 0; tick < 4000; ++tick)
    out = coupling.Tick(Middle(dvec3(x += 0.43e-6, 0, 0)), 1, enamel);
  const double before_n = -out.force_sent_n.x;
  ASSERT_TRUE(coupling.Resume(Middle(dvec3(x += 2e-6, 0, 0)), enamel));
  out = coupling.Tick(Middle(dvec3(x, 0, 0)), 1, enamel);
  EXPECT_GT(-out.force_sent_n.x, 0.1 * before_n);
  EXPECT_LE(-out.force_sent_n.x, before_n);
}

TEST(LeadMaxwellTest, ABoundFromZeroRisesOnlyAsFarAsTheTankPays) {
  Coupling coupling(OmegaCoupling());
  UniformMaterial wall(Sym3::Isotropic(1e9));
  coupling.Reset(Middle(dvec3(0)));
  for (int tick = 0; tick < 100; ++tick) coupling.Tick(Middle(dvec3(20e-6 * tick, 0, 0)), 0, wall);
  const double paid = coupling.tank_j();
  CouplingOutput out;
  for (int tick = 0; tick < 100; ++tick) out = coupling.Tick(Middle(dvec3(2e-3, 0, 0)), 1, wall);
  const double force = glm::length(out.force_sent_n);
  EXPECT_LE(0.5 * force * force / kKc, paid + 1e-12);
}

}  // namespace
}  // namespace enamel::haptics
