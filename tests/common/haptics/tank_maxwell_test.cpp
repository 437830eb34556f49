#include <gtest/gtest.h>

#include <cmath>

#include "common/base/state_hash.h"
#include "common/haptics/count_estimator.h"
#include "common/haptics/coupling.h"
#include "common/haptics/hand_stiffness.h"

namespace enamel::haptics {
namespace {

constexpr double kCell_m = 9e-6, kTick_s = 1e-3, kKc = 10'000;

// Middle of the cell that holds x.
double MiddleOfCell(double x) { return (std::floor(x / kCell_m) + 0.5) * kCell_m; }

// Feeds an axis with the positions of a way, and returns its speed at the end.
template <typename Way>
double SpeedAfter(TurningAxis& axis, double from_s, double to_s, const Way& way) {
  for (double t = from_s; t < to_s; t += kTick_s) axis.Update(t, MiddleOfCell(way(t)), kCell_m);
  return axis.speed() * axis.Fade(to_s, kCell_m);
}

// Counts in pairs 8 ms apart, a pair every 50 ms. The newest count is a pair's second for 42 of the 50 ms.
TEST(AxisEstimatorTest, CountsInPairsDoNotRaiseTheMeanOfEndsOverTwoCounts) {
  auto worst = [](int ends) {
    double most = 0;
    for (double window = 0.3; window < 0.35; window += 0.002) {
      AxisEstimator axis;
      axis.Reset(0.5 * kCell_m);
      double sum = 0;
      int cell = 0, n = 0;
      for (int k = 0; k < 3000; ++k) {
        cell += k % 50 == 0 || k % 50 == 8;
        axis.Update(k * kTick_s, (cell + 0.5) * kCell_m, 0, kCell_m);
        if (k < 1000) continue;
        sum += axis.Mean(window, ends);
        ++n;
      }
      most = std::max(most, std::fabs(sum / n / (2 * kCell_m / 0.05) - 1));
    }
    return most;
  };
  EXPECT_GT(worst(1), 0.03);
  EXPECT_LT(worst(2), 1e-6);
}

TEST(TurningAxisTest, ConstantSpeedIsExactFromTheThirdCountOn) {
  TurningAxis axis;
  axis.Reset(MiddleOfCell(0));
  double speed = 0.43e-3;
  EXPECT_NEAR(SpeedAfter(axis, 0, 4 * kCell_m / speed, [&](double t) { return speed * t; }), speed,
              0.05 * speed);
  EXPECT_NEAR(SpeedAfter(axis, 4 * kCell_m / speed, 2, [&](double t) { return speed * t; }), speed,
              0.005 * speed);
}

TEST(TurningAxisTest, AReversalIsKnownAtTheFirstNewEdge) {
  TurningAxis axis;
  axis.Reset(MiddleOfCell(0));
  auto way = [](double t) { return t < 1 ? 0.5e-3 * t : 0.5e-3 * (2 - t); };
  SpeedAfter(axis, 0, 1, way);
  // Half a cell back to the last edge, a cell to the next, and the tick's grain.
  EXPECT_NEAR(SpeedAfter(axis, 1, 1 + 2.1 * kCell_m / 0.5e-3, way), -0.5e-3, 0.05e-3);
}

TEST(TurningAxisTest, AStopFadesWithinThreeCountsAndADitheringTipIsNoMotion) {
  TurningAxis axis;
  axis.Reset(MiddleOfCell(0));
  auto way = [](double t) { return t < 1 ? 0.5e-3 * t : 0.5e-3; };
  SpeedAfter(axis, 0, 1, way);
  EXPECT_EQ(SpeedAfter(axis, 1, 1 + 3.2 * kCell_m / 0.5e-3, way), 0);
  axis.Rest();
  auto dither = [](double t) { return 100 * kCell_m + 0.1 * kCell_m * std::sin(400 * t); };
  SpeedAfter(axis, 2, 4, dither);
  EXPECT_LT(std::fabs(axis.speed() * axis.Fade(4, kCell_m)), 1e-6);
  EXPECT_FALSE(axis.TakeSwing());
}

TEST(TurningAxisTest, AMassOnASpringIsSeenToSwingAndAHandIsNot) {
  TurningAxis axis;
  axis.Reset(MiddleOfCell(0));
  SpeedAfter(axis, 0, 1, [](double t) { return 5 * kCell_m * std::sin(2 * M_PI * 20 * t); });
  EXPECT_TRUE(axis.TakeSwing());
  axis.Reset(MiddleOfCell(0));
  SpeedAfter(axis, 0, 4, [](double t) { return 50 * kCell_m * std::sin(2 * M_PI * 2 * t); });
  EXPECT_FALSE(axis.TakeSwing());
}

TEST(HandStiffnessTest, AHandThatFollowsTheRestPointIsNotTrustedAndIsAskedEverLessOften) {
  HandStiffness hand;
  hand.Reset();
  double asked = 0, last = 0, longest = 0;
  for (int k = 0; k < 60'000; ++k) {
    HandStiffness::Tick tick;
    tick.counted = k % 10 == 0;
    // Soft: the tip makes the whole move of the rest point.
    if (hand.trust() > 0) tick.tip_moved_m = dvec3(kCell_m, 0, 0);
    hand.Step(tick, kCell_m, kTick_s);
    hand.Off(dvec3(20 * kCell_m, 0, 0), true, kTick_s);
    if (hand.trust() > 0) {
      hand.Moved(dvec3(kCell_m, 0, 0));
      if (last == 0 || k * kTick_s - last > 0.1) {
        longest = std::max(longest, k * kTick_s - last);
        ++asked;
      }
      last = k * kTick_s;
    }
  }
  EXPECT_GE(asked, 3);
  EXPECT_LE(asked, 10);
  EXPECT_GT(longest, 10);
}

TEST(HandStiffnessTest, AHandThatKeepsItsWayIsTrustedWithinASecond) {
  HandStiffness hand;
  hand.Reset();
  int k = 0;
  for (; k < 5000 && hand.trust() < 1; ++k) {
    HandStiffness::Tick tick;
    tick.counted = k % 20 == 0;
    hand.Step(tick, kCell_m, kTick_s);
    hand.Off(dvec3(20 * kCell_m, 0, 0), true, kTick_s);
    if (hand.trust() > 0) hand.Moved(dvec3(kCell_m, 0, 0));
  }
  EXPECT_LT(k, 1000);
}

class Tissue final : public Material {
 public:
  Contact ContactAt(const dvec3& at, const dvec3& travel) noexcept override {
    Contact c;
    c.clearance_m = 1;
    c.engaged = solid && (everywhere || (travel.x > 0 && at.x > front - 10e-6));
    if (c.engaged) c.damping_n_s_per_m = Sym3::Isotropic(6500);
    c.coulomb_n = coulomb;
    c.threshold_n = threshold;
    return c;
  }
  void AnchorMoved(const dvec3&, const dvec3& to) noexcept override {
    front = std::max(front, to.x);
    bur = to;
  }
  bool solid = true, everywhere = true;
  double front = 0, coulomb = 0, threshold = 0;
  dvec3 bur{0};
};

CouplingParams Params() {
  CouplingParams p;
  p.law = {LawKind::kTankMaxwell, kKc, dvec3(kCell_m), kTick_s, false};
  p.law.peak_force_n = p.peak_force_n = 12;
  return p;
}

double Force(Coupling& coupling, Tissue& tissue, double x) {
  return -coupling.Tick(dvec3(MiddleOfCell(x), 0.5 * kCell_m, 0.5 * kCell_m), 1, tissue)
              .force_sent_n.x;
}

// A block that resists with any matrix, and air beside it, in steps of at most max_step. The damping
// asked for across the way out is a hundredth.
class Block final : public Material {
 public:
  Contact ContactAt(const dvec3& at, const dvec3& travel) noexcept override {
    Contact c;
    if (at.z > surface_m) return c;
    c.engaged = true;
    c.damping_n_s_per_m = b;
    if (travel.z > 0) c.damping_n_s_per_m = Sym3::Isotropic(0.01 * b.Trace());
    return c;
  }
  void AnchorMoved(const dvec3&, const dvec3& to) noexcept override {
    surface_m = std::min(surface_m, to.z);
  }
  Sym3 b = Sym3::Isotropic(6500);
  double surface_m = 1;
};

// Every force, bur and tank of 24 s in three hands: one that prescribes its way (strokes, stops, a fast
// way out through what it has cut), 0.1 kg that is pushed, 0.1 kg on a spring. + - * / alone.
uint64_t HashOfHands(double cell_m, double kc) {
  StateHash hash;
  for (int hand = 0; hand < 3; ++hand) {
    CouplingParams p = Params();
    p.law.kc_n_per_m = kc;
    p.law.resolution_m = dvec3(cell_m);
    Coupling coupling(p);
    Block block;
    dvec3 x(3.3e-6, 2.1e-6, 1.1e-6), v(0), wanted = x, force(0);
    auto cell = [&](double a) { return (std::floor(a / cell_m) + 0.5) * cell_m; };
    coupling.Reset(dvec3(cell(x.x), cell(x.y), cell(x.z)));
    for (int k = 0; k < 8000; ++k) {
      int part = k / 1000;
      block.b =
          part < 5 ? Sym3::Isotropic(part == 2 ? 300 : 6500) : Sym3::Outer(dvec3(1, 0, 0), 3000);
      if (part >= 5) block.b += Sym3::Isotropic(4000);
      double pace = part == 1 ? -0.3e-3 : part == 3 ? 0 : 0.5e-3;
      dvec3 speed = dvec3(0.3, 0.6, -0.7) * pace;
      if (part == 7) speed = dvec3(0, 0.01, k < 7100 ? 0.04 : 0);
      wanted += speed * kTick_s;
      for (int n = 0; n < 5; ++n) {
        dvec3 push = hand == 1 ? speed * 6500.0 - v * 1.0 : (wanted - x) * 1000.0 - v * 12.0;
        v += (push + force) * (kTick_s / 5 / 0.35);
        x += v * (kTick_s / 5);
      }
      if (hand == 0) x = wanted;
      CouplingOutput out = coupling.Tick(dvec3(cell(x.x), cell(x.y), cell(x.z)), 1, block);
      force = out.force_sent_n;
      for (int i = 0; i < 3; ++i) {
        hash.F64(force[i]);
        hash.F64(out.anchor_m[i]);
      }
      hash.F64(out.tank_j);
    }
  }
  return hash.value();
}

// Recordings replay only if the law repeats to the bit.
TEST(TankMaxwellTest, TheLawRepeatsToTheBit) {
  EXPECT_EQ(HashOfHands(9e-6, 10'000), 15182422191097190645u);
  EXPECT_EQ(HashOfHands(10e-6, 2'500), 15135935542032478849u);
  EXPECT_EQ(HashOfHands(20e-6, 4'000), 18131220735917175139u);
}

TEST(TankMaxwellTest, ASteadyCutHasNoEncoderRipple) {
  Coupling coupling(Params());
  Tissue tissue;
  coupling.Reset(dvec3(0.5 * kCell_m));
  double low = 1e9, high = 0, v = 0.43e-3;
  for (int k = 0; k < 6000; ++k) {
    double r = Force(coupling, tissue, v * k * kTick_s);
    if (k < 3000) continue;
    low = std::min(low, r);
    high = std::max(high, r);
  }
  EXPECT_NEAR(low, 6500 * v, 0.03);
  EXPECT_NEAR(high, 6500 * v, 0.03);
}

// All three axes count in the same tick: the rest point takes up all of it.
TEST(TankMaxwellTest, CountsOfThreeAxesInOneTickAreNoStepOfTheForce) {
  Coupling coupling(Params());
  Tissue tissue;
  coupling.Reset(dvec3(0.5 * kCell_m));
  double most = 0, v = 0.3e-3;
  for (int k = 0; k < 5000; ++k) {
    dvec3 force = coupling.Tick(dvec3(MiddleOfCell(v * k * kTick_s)), 1, tissue).force_sent_n;
    if (k > 3000) most = std::max(most, std::fabs(-force.x - 6500 * v));
  }
  EXPECT_LT(most, 0.03);
}

// A quick move along one axis, then a cut along another.
TEST(TankMaxwellTest, AnAxisThatWasLeftDoesNotSilenceTheCut) {
  Coupling coupling(Params());
  Tissue tissue;
  coupling.Reset(dvec3(0.5 * kCell_m));
  dvec3 x(0), force(0);
  for (int k = 0; k < 3000; ++k) {
    if (k < 150)
      x.y += 1.1e-6;
    else
      x.x += 0.3e-6;
    force = coupling.Tick(dvec3(MiddleOfCell(x.x), MiddleOfCell(x.y), 0.5 * kCell_m), 1, tissue)
                .force_sent_n;
  }
  EXPECT_NEAR(-force.x, 6500 * 0.3e-3, 0.1);
}

// Only what the motion drives into resists: the bur is back at the tip in the same tick, and force
// runs out along the way.
TEST(TankMaxwellTest, OnTheWayOutTheBurIsAtTheTipAndNothingIsAgainstTheMotion) {
  Coupling coupling(Params());
  Tissue tissue;
  tissue.everywhere = false;
  coupling.Reset(dvec3(0.5 * kCell_m));
  double x = 0, v = 0.43e-3, r = 0;
  for (int k = 0; k < 6000; ++k) r = Force(coupling, tissue, x += v * kTick_s);
  ASSERT_NEAR(r, 6500 * v, 0.1);
  double before = r, back = 30e-3 * kTick_s;
  for (int k = 0; k < 200; ++k) {
    r = Force(coupling, tissue, x -= back);
    EXPECT_GE(r, -0.09) << k;
    EXPECT_LE(std::fabs(r - before), kKc * (back + std::sqrt(3.0) * kCell_m)) << k;
    EXPECT_LT(std::fabs(tissue.bur.x - MiddleOfCell(x)), 25e-6) << k;
    before = r;
  }
  EXPECT_NEAR(r, 0, 1e-9);
}

TEST(TankMaxwellTest, CoulombAndThresholdAreAddedToASteadyCut) {
  for (double threshold : {0.0, 4.0}) {
    Coupling coupling(Params());
    Tissue tissue;
    tissue.coulomb = 0.5;
    tissue.threshold = threshold;
    coupling.Reset(dvec3(0.5 * kCell_m));
    double sum = 0, v = 0.43e-3;
    for (int k = 0; k < 8000; ++k) {
      double r = Force(coupling, tissue, v * k * kTick_s);
      if (k >= 4000) sum += r / 4000;
    }
    double expected = std::max(threshold, 0.5 + 6500 * v);
    EXPECT_NEAR(sum, expected, 0.15) << threshold;
  }
}

TEST(TankMaxwellTest, BelowTheThresholdNothingIsCut) {
  Coupling coupling(Params());
  Tissue tissue;
  tissue.coulomb = 0.5;
  tissue.threshold = 1.5;
  coupling.Reset(dvec3(0.5 * kCell_m));
  // 0.1 mm of stretch are 1 N.
  for (int k = 0; k < 4000; ++k) Force(coupling, tissue, std::min(0.1e-3, 0.2e-3 * k * kTick_s));
  EXPECT_LT(tissue.bur.x, 2 * kCell_m);
}

// A stopped bur meets a wall: force is bounded by letting the rest point give way, the bur stays.
TEST(TankMaxwellTest, ABoundFromZeroRisesOnlyAsFarAsTheTankPays) {
  Coupling coupling(Params());
  Tissue tissue;
  coupling.Reset(dvec3(0.5 * kCell_m));
  double x = 0, most = 0;
  for (int k = 0; k < 3000; ++k) {
    x += 0.43e-6;
    double bound = k < 1500 ? 0.0 : 1.0;
    CouplingOutput out =
        coupling.Tick(dvec3(MiddleOfCell(x), 0.5 * kCell_m, 0.5 * kCell_m), bound, tissue);
    if (k < 1500) {
      EXPECT_EQ(Dot(out.force_sent_n, out.force_sent_n), 0);
    }
    if (k == 1500) most = std::sqrt(Dot(out.force_sent_n, out.force_sent_n));
  }
  EXPECT_LT(most, 0.2);
}

}  // namespace
}  // namespace enamel::haptics
