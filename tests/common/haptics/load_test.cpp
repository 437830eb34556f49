#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "common/haptics/coupling.h"
#include "common/haptics/uniform_material.h"

// Tissue that is cut by load (math/feed_force.h), under the coupling.
namespace enamel::haptics {
namespace {

constexpr double kKc = 10e3, kCell_m = 9e-6, kTick_s = 1e-3;
// 0.2 N + 2.6 N (v/0.43 mm/s)^(1/2).
const FeedForce kEnamel{0.2, 2.6 / std::sqrt(0.43e-3), 0};

CouplingParams Params(LawKind kind) {
  CouplingParams p;
  p.law = {kind, kKc, dvec3(kCell_m), kTick_s};
  p.peak_force_n = 12;
  return p;
}

dvec3 Middle(const dvec3& x) { return (glm::floor(x / kCell_m) + 0.5) * kCell_m; }

// A hand that goes at a speed feels the closed form, whatever the law of the coupling.
TEST(LoadTest, SteadyForceIsTheTissues) {
  for (LawKind kind : {LawKind::kMaxwell, LawKind::kLeadMaxwell}) {
    for (double speed : {0.05e-3, 0.43e-3, 1.4e-3}) {
      Coupling coupling(Params(kind));
      UniformMaterial tissue(kEnamel);
      coupling.Reset(Middle(dvec3(0)));
      const int ticks = static_cast<int>(2e-3 / speed / kTick_s);
      double sum = 0;
      int counted = 0;
      for (int tick = 0; tick < ticks; ++tick) {
        const CouplingOutput out =
            coupling.Tick(Middle(dvec3(speed * kTick_s * tick, 0, 0)), 1, tissue);
        if (tick < ticks / 2) continue;
        sum -= out.force_sent_n.x;
        ++counted;
      }
      const double right = kEnamel.At(speed);
      EXPECT_NEAR(sum / counted, right, 0.02 * right) << speed;
    }
  }
}

// Below Coulomb's part the bur stays where it is and the hand feels the spring.
TEST(LoadTest, BelowCoulombsPartNothingIsCut) {
  Coupling coupling(Params(LawKind::kLeadMaxwell));
  UniformMaterial tissue(FeedForce{0.5, kEnamel.root_n_sqrt_s_per_m, 0});
  coupling.Reset(Middle(dvec3(0)));
  CouplingOutput out;
  for (int tick = 0; tick < 2000; ++tick)
    out = coupling.Tick(Middle(dvec3(40e-6, 0, 0)), 1, tissue);
  EXPECT_EQ(out.anchor_m, Middle(dvec3(0)));
  EXPECT_NEAR(-out.force_sent_n.x, 0.4, 0.15);
}

// Pressure on two faces, as in a corner. The tick's map is compared with the least of K |s - w|^2/2 + T Phi(w/T), found
// by many steps of its own: the secant of the feed before finds the way within a few ticks.
class Corner final : public Material {
 public:
  Corner(const dvec3& a, const dvec3& b) : normals_{a, b} {}
  Contact ContactAt(const dvec3&, const dvec3&) noexcept override {
    Contact c;
    c.engaged = c.by_load = true;
    c.clearance_m = 1;
    c.damping_n_s_per_m = Sym3::Isotropic(1);
    return c;
  }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}
  Sym3 SecantAt(const dvec3& feed) noexcept override {
    Sym3 b;
    for (const dvec3& n : normals_) {
      const double own = std::max(Dot(n, feed), 1e-6);
      b += Sym3::Outer(n, kEnamel.At(own) / own);
    }
    return b;
  }
  FeedForce ForceAlong(const dvec3& d) noexcept override {
    FeedForce f;
    for (const dvec3& n : normals_) {
      const double along = std::max(Dot(n, d), 0.0);
      f.coulomb_n += kEnamel.coulomb_n * along;
      f.root_n_sqrt_s_per_m += kEnamel.root_n_sqrt_s_per_m * along * std::sqrt(along);
    }
    return f;
  }

 private:
  std::vector<dvec3> normals_;
};

dvec3 Least(Corner& corner, const dvec3& s) {
  dvec3 w = s * 1e-3;
  for (int i = 0; i < 4000; ++i) {
    const Sym3 b = corner.SecantAt(w / kTick_s);
    w = s - b * SolveShifted(b, kKc * kTick_s, s);
  }
  return w;
}

TEST(LoadTest, InACornerTheWayIsTheLeastOfItsPotentialWithinAFewTicks) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  double worst = 0, worst_soon = 0;
  for (int i = 0; i < 400; ++i) {
    dvec3 a(any(random), any(random), any(random)), b(any(random), any(random), any(random));
    a = glm::normalize(a);
    b = glm::normalize(b);
    dvec3 s = (a * (0.1 + std::abs(any(random))) + b * (0.1 + std::abs(any(random)))) * 400e-6;
    if (Dot(s, a) <= 0 || Dot(s, b) <= 0) continue;
    Corner corner(a, b);
    const dvec3 least = Least(corner, s);
    if (glm::length(least) < 1e-9) continue;  // stuck
    Coupling coupling(Params(LawKind::kMaxwell));
    dvec3 tip(0);
    coupling.Reset(tip);
    for (int tick = 0; tick < 40; ++tick) {
      // The hand keeps the stretch.
      const dvec3 before = coupling.anchor_m();
      coupling.Tick(before + s, 1, corner);
      const double off = glm::length(coupling.anchor_m() - before - least) / glm::length(least);
      if (tick >= 10) worst_soon = std::max(worst_soon, off);
      if (tick == 39) worst = std::max(worst, off);
    }
  }
  std::printf("of the way in a corner: at most %.2f %% off after 10 ticks, %.3f %% after 40\n",
              100 * worst_soon, 100 * worst);
  EXPECT_LT(worst_soon, 0.05);
  EXPECT_LT(worst, 0.01);
}

// What the turning surface drags with is in the wish alone: the bur goes the same way to the bit, and the hand feels
// as much of it as the guard lets through.
TEST(LoadTest, DragIsFeltAndMovesNoBur) {
  Coupling with(Params(LawKind::kLeadMaxwell)), without(Params(LawKind::kLeadMaxwell));
  UniformMaterial dragged(kEnamel), plain(kEnamel);
  dragged.drag_n = dvec3(0, 1.2, 0);
  with.Reset(Middle(dvec3(0)));
  without.Reset(Middle(dvec3(0)));
  CouplingOutput a, b;
  double felt = 0;
  for (int tick = 0; tick < 6000; ++tick) {
    const dvec3 tip = Middle(dvec3(0.43e-6 * tick, 0, 0));
    a = with.Tick(tip, 1, dragged);
    b = without.Tick(tip, 1, plain);
    ASSERT_EQ(a.anchor_m, b.anchor_m) << tick;
    felt = std::max(felt, -a.force_sent_n.y);
  }
  EXPECT_GT(felt, 0.3);
  EXPECT_LT(felt, 1.25);
}

}  // namespace
}  // namespace enamel::haptics
