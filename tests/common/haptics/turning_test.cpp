#include "common/haptics/turning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

// The torque's spring and its theorem (README.md, "Torque"): the two bounds that the proof rests
// on, the law in closed form, and hostile hands against whole turns through a made-up material.
namespace enamel::haptics {
namespace {

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double Uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  double Signed() { return 2 * Uniform() - 1; }
  int Below(int n) { return static_cast<int>(Uniform() * n); }
  dvec3 Direction() {
    std::normal_distribution<double> normal;
    for (;;) {
      const dvec3 v(normal(random_), normal(random_), normal(random_));
      const double n = glm::length(v);
      if (n > 1e-6) return v / n;
    }
  }
  Quat Orientation() {
    std::normal_distribution<double> normal;
    return Quat{normal(random_), normal(random_), normal(random_), normal(random_)}.Normalised();
  }

 private:
  std::mt19937_64 random_;
};

// The turn by a whole rotation vector.
Quat Exp(const dvec3& phi) {
  const double angle = glm::length(phi);
  if (angle == 0) return {};
  const dvec3 v = phi * (std::sin(angle / 2) / angle);
  return {v.x, v.y, v.z, std::cos(angle / 2)};
}

double AngleBetween(const Quat& a, const Quat& b) {
  const Quat q = a * b.Conjugate();
  return 2 * std::atan2(std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z), std::fabs(q.w));
}

// The potential of min(most, sin theta), by its closed form.
double Potential(const Quat& to, const Quat& from, double most) {
  const double theta = AngleBetween(to, from);
  if (most >= 1) return 1 - std::cos(theta);
  const double first = std::asin(most), last = std::numbers::pi - first;
  if (theta <= first) return 1 - std::cos(theta);
  const double flat = 1 - std::cos(first) + most * (std::fmin(theta, last) - first);
  return theta <= last ? flat : flat + std::cos(last) - std::cos(theta);
}

TEST(TurningTest, TheTorqueIsThePotentialsGradientInBothOrientations) {
  Dice dice(1);
  for (int i = 0; i < 20000; ++i) {
    const Quat x = dice.Orientation(), r = dice.Orientation();
    const double most = dice.Below(2) ? 2 : 0.05 + dice.Uniform(), h = 1e-6;
    const dvec3 u = dice.Direction();
    const double along = Dot(BoundedSineOfTurn(x, r, most), u);
    auto slope = [&](const Quat& x1, const Quat& r1, const Quat& x0, const Quat& r0) {
      return (Potential(x1, r1, most) - Potential(x0, r0, most)) / (2 * h);
    };
    ASSERT_NEAR(slope(Exp(u * h) * x, r, Exp(u * -h) * x, r), along, 3e-6);
    ASSERT_NEAR(slope(x, Exp(u * h) * r, x, Exp(u * -h) * r), -along, 3e-6);
  }
}

// The proof needs this of the spring in place of linearity: no second derivative along a turn is
// above K, and the torque changes by at most K times the angle, wherever and with whatever bound.
TEST(TurningTest, NoSlopeOfTheTorqueIsAboveItsStiffness) {
  Dice dice(2);
  double steepest = 0, most_change = 0;
  for (int i = 0; i < 200000; ++i) {
    const Quat x = dice.Orientation();
    const Quat r =
        dice.Below(2) ? dice.Orientation() : Exp(dice.Direction() * 0.1 * dice.Uniform()) * x;
    const double most = dice.Below(2) ? 2 : 0.01 + dice.Uniform();
    const double angle = dice.Below(2) ? 1e-4 : 2 * dice.Uniform();
    const dvec3 phi = dice.Direction() * angle;
    const dvec3 before = BoundedSineOfTurn(x, r, most);
    const dvec3 after = BoundedSineOfTurn(Exp(phi) * x, r, most);
    const dvec3 moved = BoundedSineOfTurn(x, Exp(phi) * r, most);
    ASSERT_LE(glm::length(after - before), angle * (1 + 1e-9));
    ASSERT_LE(glm::length(moved - before), angle * (1 + 1e-9));
    most_change = std::fmax(most_change, glm::length(after - before) / angle);
    if (most > 1 && angle < 1e-3) {
      const double second = (Potential(Exp(phi) * x, r, most) - 2 * Potential(x, r, most) +
                             Potential(Exp(-phi) * x, r, most)) /
                            (angle * angle);
      ASSERT_LE(second, 1 + 1e-6);
      steepest = std::fmax(steepest, second);
    }
  }
  EXPECT_GT(steepest, 0.999);
  EXPECT_GT(most_change, 0.999);
}

TEST(TurningTest, AStepIsNeverLongerThanTheGuardCountsIt) {
  Dice dice(3);
  for (int i = 0; i < 20000; ++i) {
    const Quat from = dice.Orientation();
    const dvec3 turn = dice.Direction() * (dice.Below(2) ? 1e-3 : 3) * dice.Uniform();
    const Quat to = TurnedBy(turn, from);
    ASSERT_LE(AngleBetween(to, from), glm::length(turn) + 1e-15);
    ASSERT_NEAR(AngleBetween(to, from), 2 * std::atan(glm::length(turn) / 2), 1e-9);
    if (glm::length(turn) < 1) {
      ASSERT_GT(Dot(ChordOfTurn(to, from), turn), 0);
    }
  }
}

// A tissue that may be anything at any time.
class AnyMaterial final : public TurnMaterial {
 public:
  TurnContact ContactAt(const Quat&, const dvec3& turn) noexcept override {
    TurnContact out;
    out.damping_n_m_s = damping;
    if (free_way && Dot(turn, way_out) > 0) out.damping_n_m_s = Sym3{};
    if (clear) out.clear_rad = glm::length(turn);
    return out;
  }
  void BurTurned(const Quat&, bool) noexcept override { ++turns; }

  Sym3 damping;
  bool free_way = false, clear = false;
  dvec3 way_out{0};
  int turns = 0;
};

TurningParams Params(int delay = 0) {
  TurningParams p;
  p.k_n_m_per_rad = 1;
  p.peak_n_m = 2;
  p.cell_rad = 1e-3;
  p.tick_s = 1e-3;
  p.delay_ticks = delay;
  p.max_turn_rad = 5e-3;
  return p;
}

TEST(TurningTest, AHeldAngleInUniformTissueFallsAsItsClosedForm) {
  const TurningParams p = Params();
  AnyMaterial tissue;
  const double b = 0.2, held = 0.5;  // tan(theta/2) falls as exp(-t K/B)
  tissue.damping = Sym3::Isotropic(b);
  Turning turning(p);
  turning.Reset(Quat{});
  turning.Tick(Quat{}, tissue);
  ASSERT_TRUE(turning.felt());
  const Quat device = Exp(dvec3(0, held, 0));
  for (int tick = 1; tick <= 600; ++tick) {
    const dvec3 torque = turning.Tick(device, tissue);
    const double theta = 2 * std::atan(std::tan(held / 2) * std::exp(-tick * p.tick_s / b));
    ASSERT_NEAR(-torque.y, std::sin(theta), 0.01 * std::sin(theta) + 1e-6) << tick;
    ASSERT_EQ(torque.x, 0);
    ASSERT_NEAR(torque.z, 0, 1e-15);
  }
}

TEST(TurningTest, InAirTheTorqueStaysBelowWhatTheCellHides) {
  for (int delay = 0; delay <= 2; ++delay) {
    const TurningParams p = Params(delay);
    AnyMaterial air;
    Turning turning(p);
    turning.Reset(Quat{});
    for (int i = 0; i <= delay; ++i) turning.Tick(Quat{}, air);
    ASSERT_TRUE(turning.felt());
    double most = 0;
    for (int tick = 0; tick < 5000; ++tick) {
      const dvec3 torque = turning.Tick(Exp(dvec3(0.5 * std::sin(tick * 0.01), 0, 0)), air);
      most = std::fmax(most, glm::length(torque));
    }
    // Stretch and turn differ by the cube of the angle.
    EXPECT_LE(most, p.k_n_m_per_rad * p.cell_rad * (1 + 1e-3)) << delay;
    EXPECT_GT(air.turns, 100);
  }
}

TEST(TurningTest, AWallHoldsAndTurningBackIsFreeAtOnce) {
  const TurningParams p = Params();
  AnyMaterial wall;
  wall.damping = Sym3::Isotropic(1e3);
  wall.free_way = true;
  wall.way_out = dvec3(-1, 0, 0);
  Turning turning(p);
  turning.Reset(Quat{});
  turning.Tick(Quat{}, wall);
  for (int tick = 1; tick <= 200; ++tick) {
    const dvec3 torque = turning.Tick(Exp(dvec3(tick * 1e-3, 0, 0)), wall);
    ASSERT_NEAR(torque.x, -std::sin(tick * 1e-3), 1e-3);
  }
  // Out again, and on past where it came from: never held by more than the cell.
  for (int tick = 200; tick >= -200; --tick) {
    const dvec3 torque = turning.Tick(Exp(dvec3(tick * 1e-3, 0, 0)), wall);
    ASSERT_LE(torque.x, p.k_n_m_per_rad * p.cell_rad * (1 + 1e-9)) << tick;
  }
}

TEST(TurningTest, TheTorqueIsNeverAboveItsBound) {
  TurningParams p = Params();
  p.peak_n_m = 0.03;
  AnyMaterial tissue;
  Dice dice(4);
  Turning turning(p);
  turning.Reset(Quat{});
  int bounded = 0;
  for (int tick = 0; tick < 20000; ++tick) {
    if (tick % 50 == 0) tissue.damping = Sym3::Isotropic(dice.Below(2) ? 1e3 * dice.Uniform() : 0);
    const double torque = glm::length(turning.Tick(
        tick % 7 ? Exp(dice.Direction() * dice.Uniform()) : dice.Orientation(), tissue));
    ASSERT_LE(torque, 0.03 * (1 + 1e-12));
    bounded += torque > 0.0299;
  }
  EXPECT_GT(bounded, 1000);
}

TEST(TurningTest, WhatIsNotANumberTurnsNothing) {
  Turning turning(Params());
  AnyMaterial broken;
  turning.Reset(Quat{});
  turning.Tick(Quat{}, broken);
  for (double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    broken.damping = Sym3::Isotropic(bad);
    const dvec3 torque = turning.Tick(Exp(dvec3(0.1, 0, 0)), broken);
    EXPECT_NEAR(torque.x, -std::sin(0.1), 1e-12);
    EXPECT_EQ(turning.bur().w, 1);
    const dvec3 none = turning.Tick(Quat{bad, 0, 0, 1}, broken);
    EXPECT_EQ(glm::length(none), 0);
    EXPECT_EQ(turning.bur().w, 1);
  }
}

TEST(TurningTest, AfterAGapTheTorqueWaitsUntilTheHandIsBackAtTheBur) {
  const TurningParams p = Params();
  AnyMaterial wall;
  wall.damping = Sym3::Isotropic(1e3);
  Turning turning(p);
  turning.Reset(Quat{});
  turning.Tick(Quat{}, wall);
  ASSERT_NEAR(turning.Tick(Exp(dvec3(0.1, 0, 0)), wall).x, -std::sin(0.1), 1e-4);
  // Farther than the bur may follow, and as far as it may.
  EXPECT_FALSE(turning.CanResume(Exp(dvec3(0.106, 0, 0))));
  ASSERT_TRUE(turning.CanResume(Exp(dvec3(0.104, 0, 0))));
  turning.Resume(Exp(dvec3(0.104, 0, 0)), wall);
  EXPECT_NEAR(AngleBetween(turning.bur(), Quat{}), 0.004, 1e-6);
  for (int mrad = 104; mrad >= 6; --mrad) {
    ASSERT_EQ(glm::length(turning.Tick(Exp(dvec3(mrad * 1e-3, 0, 0)), wall)), 0) << mrad;
    ASSERT_FALSE(turning.felt());
  }
  EXPECT_EQ(glm::length(turning.Tick(turning.bur(), wall)), 0);
  EXPECT_TRUE(turning.felt());
  EXPECT_GT(glm::length(turning.Tick(Exp(dvec3(0.02, 0, 0)) * turning.bur(), wall)), 0.01);
}

// A device, its reading and the spring, T = 1. b/T and c are the least that K = 1 may have,
// whatever parameters the guard gets. The balance counts the torques as the device feels them.
struct Bench {
  struct Is {  // what is true of the device, and what the guard is told otherwise
    int delay = 0;
    double stiffness = 1, friction = 1, peak = 1e3;
    bool told_cell = true, told_delay = true;
  };
  static constexpr double kCell = 0.01;

  explicit Bench(const Is& is)
      : b(0.5 * (is.delay + 1) * (is.delay + 1)), c(is.friction * kCell), turning(ParamsOf(is)) {
    stiffness = is.stiffness;
    under_way.assign(static_cast<size_t>(is.delay), dvec3(0));
    turning.Reset(x);
    for (int i = 0; i < is.delay; ++i) turning.Reset(x);
  }
  static TurningParams ParamsOf(const Is& is) {
    TurningParams p;
    p.k_n_m_per_rad = is.stiffness;
    p.peak_n_m = is.peak;
    p.cell_rad = is.told_cell ? kCell : 1e-9;
    p.tick_s = 1;
    p.delay_ticks = is.told_delay ? is.delay : 0;
    p.max_turn_rad = 0.05;
    return p;
  }

  // The reading is off by `off` cells; then the hand turns by phi, or so as to draw the most.
  void Tick(const dvec3& off, const dvec3& phi, bool greedy = false) {
    const bool before = turning.felt();
    const dvec3 torque = turning.Tick(Exp(off * kCell) * x, material);
    if (turning.felt() && !before) floor -= 0.5 * stiffness * kCell * kCell;
    Turn(torque, phi, greedy);
  }
  void Turn(const dvec3& torque, dvec3 phi, bool greedy) {
    under_way.push_back(torque);
    const dvec3 felt = under_way.front();
    under_way.pop_front();
    const double size = glm::length(felt);
    if (greedy) phi = size > c ? felt * ((size - c) / (2 * b * size)) : dvec3(0);
    const double way = glm::length(phi);
    balance += -Dot(felt, phi) + b * way * way + c * way;
    x = (Exp(phi) * x).Normalised();
    lowest = std::fmin(lowest, balance - floor);
  }
  // Ticks without torque, in which the hand turns too.
  void Gap(const dvec3& phi, const dvec3& off) {
    Turn(dvec3(0), phi, false);
    const Quat device = Exp(off * kCell) * x;
    if (turning.CanResume(device)) {
      turning.Resume(device, material);
    } else {
      turning.Reset(device);
    }
    Turn(dvec3(0), phi, false);
  }

  double b, c, stiffness;
  Turning turning;
  AnyMaterial material;
  Quat x;
  std::deque<dvec3> under_way;
  double balance = 0, floor = 0, lowest = 0;
};

void AnyTissue(Dice& dice, AnyMaterial& material) {
  const double scale = std::pow(10, 4 * dice.Uniform() - 2);
  switch (dice.Below(5)) {
    case 0:
      material.damping = Sym3{};
      break;
    case 1:
      material.damping = Sym3::Isotropic(1e6);
      break;
    case 2:
      material.damping = Sym3::Outer(dice.Direction(), scale);
      break;
    default:
      material.damping =
          Sym3::Outer(dice.Direction(), scale) + Sym3::Outer(dice.Direction(), dice.Uniform());
  }
  material.free_way = dice.Below(3) == 0;
  material.way_out = dice.Direction();
  material.clear = material.damping.IsZero() && dice.Below(2);
}

struct Play {
  double lowest = 0;
  int felt = 0;
};

// One hostile hand: dithers, thefts, swings, strokes, half turns, gaps. One trick a game, since the
// loss of one would hide the gain of another; a tenth of the games mixes them.
Play PlayGame(const Bench::Is& is, unsigned seed, int ticks) {
  Bench bench(is);
  Dice dice(seed);
  Play play;
  dvec3 stroke(0), axis = dice.Direction();
  const int tricks = 9;
  int mode = static_cast<int>(seed) % (tricks + 1);
  const bool mixed = mode == tricks;
  for (int i = 0; i < ticks; ++i) {
    if (i % 20 == 0 && dice.Below(2)) {
      if (mixed) mode = dice.Below(tricks);
      axis = dice.Direction();
    }
    if (mode == 4 || dice.Below(10) == 0) AnyTissue(dice, bench.material);
    dvec3 off = dice.Direction() * (dice.Below(3) ? 1.0 : dice.Uniform());
    dvec3 phi(0);
    bool greedy = false;
    switch (mode) {
      case 0:
        phi = dice.Direction() * 0.3 * dice.Uniform();
        break;
      case 1:
      case 4:  // over a cell's edge and back, whatever the tissue
        phi = axis * (Bench::kCell * (i % 2 ? 0.4 : -0.4));
        off = axis * (i % 2 ? 1.0 : -1.0);
        break;
      case 2:
        greedy = true;
        off = axis * (dice.Below(2) ? 1.0 : -1.0);
        break;
      case 3:
        stroke = stroke * 0.9 + dice.Direction() * 0.02;
        phi = stroke;
        break;
      case 5:
        if (dice.Below(10) == 0) phi = axis * std::numbers::pi * dice.Uniform();
        break;
      case 6:
        if (dice.Below(10) == 0) bench.Gap(axis * 0.01 * dice.Uniform(), off);
        greedy = dice.Below(2) == 0;
        phi = axis * 0.05;
        break;
      case 7:  // out and back
        phi = axis * 0.08 * std::sin(i * 0.7);
        break;
      case 8:  // the bur follows one end of the cell through air; a wall, and the other end
        bench.material.damping = Sym3::Isotropic(i % 2 ? 1e6 : 0);
        bench.material.free_way = false;
        off = axis * (i % 2 ? -1.0 : 1.0);
        greedy = true;
        break;
    }
    bench.Tick(off, phi, greedy);
    play.felt += bench.turning.felt();
  }
  play.lowest = bench.lowest;
  return play;
}

// A game about one axis that breeds: reading, turn and tissue of each tick, changed a little at a
// time; what draws more is kept.
class Breeder {
 public:
  Breeder(const Bench::Is& is, unsigned seed) : is_(is), dice_(seed) {}
  // The lowest balance over its floor that was found.
  double Best(int tries) {
    std::vector<Gene> best(24);
    for (Gene& gene : best) gene = Any();
    double score = Score(best);
    for (int i = 0; i < tries; ++i) {
      std::vector<Gene> child = best;
      const int changes = 1 + dice_.Below(3);
      for (int k = 0; k < changes; ++k) {
        Gene& gene = child[static_cast<size_t>(dice_.Below(static_cast<int>(child.size())))];
        if (dice_.Below(3) == 0) gene = Any();
        gene.turn += (dice_.Below(2) ? 0.1 : 0.01) * size_ * dice_.Signed();
      }
      const double found = Score(child);
      if (found <= score) score = found, best = child;
    }
    return lowest_;
  }

 private:
  struct Gene {
    double off, turn;
    int tissue;
  };
  Gene Any() { return {dice_.Below(2) ? 1.0 : -1.0, size_ * dice_.Signed(), dice_.Below(4)}; }
  // The end of the game counts, so that what is stored underway is no loss.
  double Score(const std::vector<Gene>& genes) {
    Bench bench(is_);
    bench.Tick(dvec3(1, 0, 0), dvec3(0));
    for (const Gene& gene : genes) {
      constexpr double kDamping[] = {0, 1e6, 1, 0.1};
      bench.material.damping = Sym3::Isotropic(kDamping[gene.tissue]);
      bench.Tick(dvec3(gene.off, 0, 0), dvec3(gene.turn, 0, 0));
    }
    for (int i = 0; i < 8; ++i) bench.Tick(dvec3(-1, 0, 0), dvec3(0), true);
    lowest_ = std::fmin(lowest_, bench.lowest);
    return bench.balance - bench.floor;
  }

  const Bench::Is is_;
  Dice dice_;
  const double size_ = dice_.Below(2) ? 0.3 : 0.03;
  double lowest_ = 0;
};

double Worst(const Bench::Is& is, int games, int bred, int* felt = nullptr) {
  double lowest = 0;
  for (unsigned seed = 0; seed < static_cast<unsigned>(games); ++seed) {
    const Play play = PlayGame(is, seed, 400);
    lowest = std::fmin(lowest, play.lowest);
    if (felt != nullptr) *felt += play.felt;
  }
  for (unsigned seed = 1; seed <= static_cast<unsigned>(bred); ++seed) {
    lowest = std::fmin(lowest, Breeder(is, seed).Best(1500));
  }
  return lowest;
}

TEST(TurningTest, NoHandDrawsMoreThanWasStoredAtWhateverDelay) {
  for (int delay = 0; delay <= 2; ++delay) {
    for (double peak : {1e3, 0.05}) {
      int felt = 0;
      EXPECT_GE(Worst({.delay = delay, .peak = peak}, 300, 12, &felt), -1e-12)
          << "delay " << delay << ", bound " << peak;
      EXPECT_GT(felt, 40000) << "delay " << delay;
    }
  }
}

// The attacks are sharp: without a clause the same hands draw more than was stored.
TEST(TurningTest, WithoutItsClausesTheBalanceEndsUnderItsFloor) {
  for (int delay = 0; delay <= 2; ++delay) {
    SCOPED_TRACE("delay " + std::to_string(delay));
    EXPECT_LT(Worst({.delay = delay, .stiffness = 10, .friction = 10}, 30, 0), -1e-4);
    EXPECT_LT(Worst({.delay = delay, .friction = 0}, 30, 0), -1e-3);
    EXPECT_LT(Worst({.delay = delay, .told_cell = false}, 30, 0), -1e-4);
  }
  EXPECT_LT(Worst({.delay = 1, .told_delay = false}, 0, 12), -1e-6);
}

TEST(TurningTest, ASavedStateGoesOnToTheBit) {
  Dice dice(9);
  AnyMaterial tissue;
  Turning a(Params(1)), b(Params(1));
  a.Reset(Quat{});
  for (int tick = 0; tick < 400; ++tick) {
    if (tick % 20 == 0) AnyTissue(dice, tissue);
    if (tick == 200) {
      StateArchive out;
      a.VisitState(out);
      const Bytes saved = out.Take();
      StateArchive in(saved);
      b.VisitState(in);
      ASSERT_TRUE(in.Complete());
    }
    const Quat device = Exp(dice.Direction() * 0.05);
    const dvec3 torque = a.Tick(device, tissue);
    if (tick >= 200) {
      ASSERT_EQ(torque, b.Tick(device, tissue));
    }
  }
}

}  // namespace
}  // namespace enamel::haptics
