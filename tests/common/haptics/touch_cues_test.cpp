#include "common/haptics/touch_cues.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "tests/support/dice.h"

namespace enamel::haptics {
namespace {

using testing_support::Dice;

constexpr double kTick_s = 1e-3, kTurn = 6.28318530717958647692;
constexpr double kCell_m = 20e-6;
constexpr double kRounding_j = 1e-15;

double Length(const dvec3& v) { return std::sqrt(Dot(v, v)); }

TouchCueParams Generous() {
  TouchCueParams p;
  p.contact_n = 0.3;
  p.chatter_n = 0.2;
  p.peak_force_n = 8;
  p.account.energy_j = 1;
  p.account.tick_s = kTick_s;
  return p;
}

// Moves along x at 15 mm/s through air and meets tissue of B at tick 100.
std::vector<double> KnockOf(TouchCues& cues, double b, double speed_m_per_s, int ticks = 200) {
  std::vector<double> out;
  for (int k = 0; k < 100 + ticks; ++k) {
    TouchCueInput in;
    in.tip_m.x = k * speed_m_per_s * kTick_s;
    in.contact_read = true;
    in.engaged = k >= 100;
    in.tissue_b_n_s_per_m = in.engaged ? b : 0;
    dvec3 c = cues.Tick(in);
    EXPECT_EQ(c.y, 0);
    EXPECT_EQ(c.z, 0);
    if (k < 100) {
      EXPECT_EQ(c.x, 0);
    } else {
      out.push_back(c.x);
    }
  }
  return out;
}

TEST(TouchCues, KnockIsADecayingSineAgainstTheWayItCame) {
  for (double b : {50.0, 1500.0, 6500.0}) {
    TouchCues cues(Generous());
    const double speed = 0.015, h = b / (b + 1000), hz = 60 + (200 - 60) * h;
    std::vector<double> c = KnockOf(cues, b, speed);
    const double fades_s = 1.5 / hz, r = fades_s / (fades_s + kTick_s);
    // The smoothed speed has 100 ticks of 20 ms behind it.
    const double seen = speed * (1 - std::pow(20.0 / 21, 100));
    const double amplitude = 0.3 * seen / 0.02;
    double keep = 1;
    for (size_t i = 0; i < c.size(); ++i) {
      keep *= r;
      const double expected = -amplitude * keep * std::sin(kTurn * hz * kTick_s * (i + 1.0));
      const bool over = amplitude * keep <= 0.01 * 0.3;
      EXPECT_NEAR(c[i], over ? 0 : expected, 1e-12) << b << " tick " << i;
    }
    EXPECT_EQ(c.back(), 0);
    EXPECT_NEAR(cues.KnockFrequency_hz(b), hz, 1e-9);
  }
}

TEST(TouchCues, KnockGrowsWithTheSpeedUpToItsBoundAndSlowContactHasNone) {
  auto largest = [](double speed, double half_m) {
    TouchCueParams p = Generous();
    p.account.cell_half_m = dvec3(half_m);
    TouchCues cues(p);
    double most = 0;
    for (double v : KnockOf(cues, 1e4, speed)) most = std::max(most, std::fabs(v));
    return most;
  };
  EXPECT_NEAR(largest(0.01, 0) / largest(0.005, 0), 2, 1e-9);
  EXPECT_EQ(largest(0.04, 0), largest(0.4, 0));
  EXPECT_LE(largest(0.4, 0), 0.3);
  // A cell of 20 um in 20 ms is 1 mm/s.
  EXPECT_EQ(largest(0.9e-3, 10e-6), 0);
  EXPECT_GT(largest(1.2e-3, 10e-6), 0);
}

TEST(TouchCues, ContactIsNewsOnlyAfterThirtyMillisecondsOfAir) {
  for (int air : {10, 40}) {
    TouchCues cues(Generous());
    std::vector<double> c;
    for (int k = 0; k < 500; ++k) {
      TouchCueInput in;
      in.tip_m.x = k * 0.01 * kTick_s;
      in.contact_read = true;
      in.engaged = k >= 100 && !(k >= 300 && k < 300 + air);
      in.tissue_b_n_s_per_m = in.engaged ? 6500 : 0;
      c.push_back(cues.Tick(in).x);
    }
    auto any = [&](int from, int to) {
      return std::any_of(c.begin() + from, c.begin() + to, [](double v) { return v != 0; });
    };
    EXPECT_TRUE(any(100, 200));
    EXPECT_FALSE(any(250, 300));
    EXPECT_EQ(any(300, 500), air == 40) << air;
  }
}

// The chatter at load R in tissue of B, with the bur at a speed.
std::vector<double> ChatterOf(double krpm, double load_n, double b, double rate_hz, int ticks) {
  TouchCueParams p = Generous();
  p.contact_n = 0;
  p.account.tick_s = 1 / rate_hz;
  TouchCues cues(p);
  std::vector<double> out;
  for (int k = 0; k < ticks; ++k) {
    TouchCueInput in;
    in.coupling_n = in.pressed_n = dvec3(0, 0, load_n);
    in.across = dvec3(0, 1, 0);
    in.contact_read = in.engaged = true;
    in.tissue_b_n_s_per_m = b;
    in.bur_speed_krpm = krpm;
    dvec3 c = cues.Tick(in);
    EXPECT_EQ(c.x, 0);
    EXPECT_EQ(c.z, 0);
    out.push_back(c.y);
  }
  return out;
}

TEST(TouchCues, ChatterIsASineAtAFortiethOfTheBursSpeed) {
  struct Case {
    double krpm, rate_hz, hz;
  };
  const Case cases[] = {{400, 1000, 400e3 / 60 / 40},
                        {200, 1000, 200e3 / 60 / 40},
                        {40, 1000, 60},
                        {900, 1000, 200},
                        {900, 4000, 230},
                        {400, 500, 100}};
  for (const Case& c : cases) {
    const double load = 2, b = 3000;
    std::vector<double> got = ChatterOf(c.krpm, load, b, c.rate_hz, 2000);
    const double amplitude = 0.2 * load / (load + 1) * b / (b + 1000);
    EXPECT_EQ(got[0], 0);  // nothing is sent before the tip's speed is known
    for (size_t k = 1; k < got.size(); ++k) {
      EXPECT_NEAR(got[k], amplitude * std::sin(kTurn * c.hz / c.rate_hz * (k + 1.0)), 1e-11)
          << c.krpm << " tick " << k;
    }
  }
}

TEST(TouchCues, ChatterGrowsWithLoadAndHardnessAndStaysUnderItsBound) {
  auto largest = [](double load, double b) {
    double most = 0;
    for (double v : ChatterOf(400, load, b, 1000, 500)) most = std::max(most, std::fabs(v));
    return most;
  };
  EXPECT_LT(largest(0.5, 6500), largest(3, 6500));
  EXPECT_LT(largest(3, 50), largest(3, 1500));
  EXPECT_LE(largest(1e3, 1e9), 0.2);
  EXPECT_EQ(largest(0, 6500), 0);
  EXPECT_EQ(largest(3, 0), 0);
}

TEST(TouchCues, NothingInFreeAirWithAStillBurOrWhileSuspended) {
  TouchCues cues(Generous());
  for (int k = 0; k < 3000; ++k) {
    TouchCueInput in;
    in.tip_m = dvec3(0.003 * std::sin(0.01 * k), 1e-6 * k, 0);
    in.coupling_n = in.pressed_n = dvec3(1, 0, 0);  // stored force may still run out in air
    in.bur_speed_krpm = 400;
    in.contact_read = k % 3 != 0;
    in.tissue_b_n_s_per_m = 6500;
    if (k >= 1000) {
      in.engaged = true;
      in.suspended = k < 2000;
      if (k >= 2000) in.bur_speed_krpm = 0;
    }
    dvec3 c = cues.Tick(in);
    // From tick 2000 on there is the one knock of the contact.
    if (k < 2000 || k >= 2200) {
      EXPECT_EQ(c, dvec3(0)) << k;
    }
  }
}

TEST(TouchCues, NothingWithoutEnergyOrForceOrUnder300Hz) {
  TouchCueParams p = Generous();
  EXPECT_TRUE(TouchCues(p).enabled());
  p.account.energy_j = 0;
  EXPECT_FALSE(TouchCues(p).enabled());
  p = Generous();
  p.contact_n = p.chatter_n = 0;
  EXPECT_FALSE(TouchCues(p).enabled());
  p = Generous();
  p.account.tick_s = 1 / 299.0;
  EXPECT_FALSE(TouchCues(p).enabled());
  p.account.tick_s = 1 / 300.0;
  EXPECT_TRUE(TouchCues(p).enabled());
}

TEST(TouchCues, CouplingAndCueTogetherStayWithinThePeak) {
  TouchCueParams p = Generous();
  p.chatter_n = 2;
  p.peak_force_n = 3;
  TouchCues cues(p);
  double least_left = 1e9;
  bool any = false, at_peak = false;
  for (int k = 0; k < 5000; ++k) {
    TouchCueInput in;
    const double angle = 0.37 * k, load = 3.0 * (k % 1000) / 999;
    in.coupling_n = in.pressed_n = dvec3(load * std::cos(angle), load * std::sin(angle), 0);
    in.contact_read = in.engaged = true;
    in.tissue_b_n_s_per_m = 6500;
    in.bur_speed_krpm = 400;
    in.bounded = k >= 4000;
    dvec3 c = cues.Tick(in);
    double left = 3 - Length(in.coupling_n + c);
    least_left = std::min(least_left, left);
    any = any || c != dvec3(0);
    at_peak = at_peak || (c != dvec3(0) && left < 1e-9);
    if (in.bounded) {
      EXPECT_EQ(c, dvec3(0));
    }
  }
  EXPECT_TRUE(any);
  EXPECT_TRUE(at_peak);
  EXPECT_GE(least_left, -1e-12);
}

TEST(TouchCues, GoesOnFromSavedStateToTheBit) {
  TouchCueParams p = Generous();
  p.account.energy_j = 3e-5;
  p.account.power_w = 1e-3;
  p.account.cell_half_m = dvec3(10e-6);
  p.account.delay_ticks = 2;
  auto input = [](int k) {
    TouchCueInput in;
    in.tip_m = dvec3(20e-6 * std::floor(0.9 * k), 20e-6 * std::floor(30 * std::sin(0.05 * k)), 0);
    in.coupling_n = in.pressed_n = dvec3(1.5, 0.2, 0);
    in.contact_read = true;
    in.engaged = k % 300 > 80;
    in.tissue_b_n_s_per_m = 6500;
    in.bur_speed_krpm = 300 + k % 50;
    in.gap = k == 470;
    return in;
  };
  TouchCues a(p), b(p);
  for (int k = 0; k < 400; ++k) a.Tick(input(k));
  StateArchive save;
  a.VisitState(save);
  Bytes bytes = save.Take();
  StateArchive load((ByteView(bytes)));
  b.VisitState(load);
  ASSERT_TRUE(load.Complete());
  bool any = false;
  for (int k = 400; k < 800; ++k) {
    dvec3 x = a.Tick(input(k)), y = b.Tick(input(k));
    ASSERT_EQ(x, y) << k;
    any = any || x != dvec3(0);
  }
  EXPECT_TRUE(any);
}

// Checks the account by separate bookkeeping: a true tip, an encoder and the force that is felt;
// only the cue comes from the account. The attacker chooses the cue wanted, the motion, and the
// delay of every tick and axis.
struct Attack {
  double energy_j = 1e-4, power_w = 0;
  int delay = 0;
  bool with_account = true;
};

struct Move {
  dvec3 way_m{0};  // of the true tip
  dvec3 mix{0};    // per axis: 0 felt as sent `late` ticks ago, 1: a tick later than that
  int late = 0;
};

class Hand {
 public:
  explicit Hand(const Attack& a) : attack_(a), account_(Params(a)) {}

  // One tick. `choose` sees the forces under way (newest first) and the tip inside its cell.
  void Tick(const std::function<Move(const std::vector<dvec3>&, const dvec3&)>& choose,
            const dvec3& wanted) {
    dvec3 p = Read(x_);
    const double paid = attack_.energy_j + attack_.power_w * kTick_s * ticks_;
    dvec3 cue = attack_.with_account ? account_.Afford(p, wanted) : wanted;
    under_way_.insert(under_way_.begin(), cue);
    if (under_way_.size() > 20) under_way_.pop_back();
    while (under_way_.size() < 20) under_way_.push_back(dvec3(0));
    dvec3 most(0);
    for (int j = 0; j <= attack_.delay; ++j) {
      for (int i = 0; i < 3; ++i) most[i] = std::max(most[i], std::fabs(under_way_[j][i]));
    }
    // The cell's error where a stretch of time begins.
    if (hidden_ < 0) hidden_ = 0.5 * kCell_m * (most.x + most.y + most.z);
    if (cue != dvec3(0)) {
      excess_ = 0;
      paid_ = paid;
      const int d = attack_.delay + 1;
      for (int i = 0; i < 3; ++i) {
        allowed_[i] = std::fabs(p[i] - last_[i]) + kCell_m +
                      d * CueAccount::kFastest_m_per_s2 * kTick_s * kTick_s;
      }
    }
    last_ = p;
    Move m = choose(under_way_, x_ - p);
    int late = std::min(m.late, attack_.delay);
    double gained = 0;
    for (int i = 0; i < 3; ++i) {
      int later = std::min(late + 1, attack_.delay);
      double f = under_way_[late][i] * (1 - m.mix[i]) + under_way_[later][i] * m.mix[i];
      gained += f * m.way_m[i];
      excess_ += most[i] * std::max(0.0, std::fabs(m.way_m[i]) - allowed_[i]);
    }
    x_ += m.way_m;
    drawn_j += gained;
    ++ticks_;
    const double over = drawn_j - paid_ - excess_;
    worst_j = std::max(worst_j, over);
    most_j = std::max(most_j, drawn_j);
    most_excess_j = std::max(most_excess_j, excess_);
    // Any stretch of time: what was drawn since the cheapest moment.
    const double steady = drawn_j - attack_.power_w * kTick_s * ticks_;
    worst_stretch_j =
        std::max(worst_stretch_j, steady - lowest_ - hidden_ - attack_.energy_j - excess_);
    if (steady < lowest_) {
      lowest_ = steady;
      hidden_ = -1;
    }
  }

  double drawn_j = 0, most_j = 0, worst_j = -1e9, most_excess_j = 0, worst_stretch_j = -1e9;
  int ticks() const { return ticks_; }

 private:
  static CueAccountParams Params(const Attack& a) {
    CueAccountParams p;
    p.energy_j = a.energy_j;
    p.power_w = a.power_w;
    p.tick_s = kTick_s;
    p.cell_half_m = dvec3(0.5 * kCell_m);
    p.delay_ticks = a.delay;
    return p;
  }
  static dvec3 Read(const dvec3& x) {
    dvec3 p;
    for (int i = 0; i < 3; ++i) p[i] = (std::floor(x[i] / kCell_m) + 0.5) * kCell_m;
    return p;
  }

  Attack attack_;
  CueAccount account_;
  std::vector<dvec3> under_way_;
  dvec3 x_{3e-6, -4e-6, 1e-6}, last_ = Read(x_), allowed_{0};
  double paid_ = 0, excess_ = 0, lowest_ = 0, hidden_ = -1;
  int ticks_ = 0;
};

// The wave the cues would send.
dvec3 Wave(int k, double hz, const dvec3& direction, double newton = 0.2) {
  return direction * (newton * std::sin(kTurn * hz * kTick_s * k));
}

const dvec3 kOblique(0.48, 0.64, 0.6);

// A hand that moves with the force it feels, at any speed it likes, with at most the acceleration
// that the account counts with.
Hand InPhase(const Attack& attack, double hz, double fastest, int late, int ticks) {
  Hand hand(attack);
  dvec3 v(0);
  const double step = CueAccount::kFastest_m_per_s2 * kTick_s;
  for (int k = 0; k < ticks; ++k) {
    hand.Tick(
        [&](const std::vector<dvec3>& c, const dvec3&) {
          Move m;
          m.late = late;
          for (int i = 0; i < 3; ++i) {
            // The force felt next is already known: turn in time.
            double goal = c[static_cast<size_t>(late)][i] > 0 ? fastest : -fastest;
            v[i] += std::clamp(goal - v[i], -step, step);
          }
          m.way_m = v * kTick_s;
          return m;
        },
        Wave(k, hz, kOblique));
  }
  return hand;
}

TEST(CueAccount, AHandInPhaseDrawsNoMoreThanWasGiven) {
  double most_share = 0, without = 0;
  for (int delay = 0; delay <= 2; ++delay) {
    for (double power : {0.0, 5e-4}) {
      for (double hz : {60.0, 117.0, 200.0}) {
        for (double fastest : {1e-3, 0.02, 0.2, 2.0}) {
          for (int late = 0; late <= delay; ++late) {
            Attack a;
            a.delay = delay;
            a.power_w = power;
            Hand hand = InPhase(a, hz, fastest, late, 4000);
            EXPECT_LE(hand.worst_j, kRounding_j) << delay << " " << hz << " " << fastest;
            EXPECT_LE(hand.worst_stretch_j, kRounding_j) << delay << " " << hz << " " << fastest;
            EXPECT_EQ(hand.most_excess_j, 0);
            if (power == 0) most_share = std::max(most_share, hand.most_j / a.energy_j);
            a.with_account = false;
            without = std::max(without, InPhase(a, hz, fastest, late, 4000).most_j / 1e-4);
          }
        }
      }
    }
  }
  EXPECT_GT(most_share, 0.3);  // the attack is one, and the account not merely stingy
  EXPECT_GT(without, 100);     // and it is the account that holds it
}

// Inside its cell the tip is not seen at all: the attack that pays for nothing it shows.
Hand Dither(const Attack& attack, double hz, int ticks) {
  Hand hand(attack);
  for (int k = 0; k < ticks; ++k) {
    hand.Tick(
        [&](const std::vector<dvec3>& c, const dvec3& inside) {
          Move m;
          for (int i = 0; i < 3; ++i) {
            double goal = std::copysign(0.4999 * kCell_m, c[0][i]);
            m.way_m[i] = goal - inside[i];
          }
          return m;
        },
        Wave(k, hz, kOblique));
  }
  return hand;
}

TEST(CueAccount, AHandThatDithersInsideACellIsPaidForToo) {
  for (int delay = 0; delay <= 2; ++delay) {
    for (double hz : {60.0, 150.0, 200.0}) {
      Attack a;
      a.delay = delay;
      a.energy_j = 5e-5;
      Hand hand = Dither(a, hz, 20'000);
      EXPECT_LE(hand.worst_j, kRounding_j);
      EXPECT_EQ(hand.most_excess_j, 0);
      a.with_account = false;
      EXPECT_GT(Dither(a, hz, 20'000).most_j, 20 * a.energy_j);
    }
  }
}

// A hand that first gives energy does not get it back on top: nothing above energy_j is kept.
TEST(CueAccount, EnergyGivenDoesNotPileUp) {
  for (int delay = 0; delay <= 2; ++delay) {
    Attack a;
    a.delay = delay;
    Hand hand(a);
    dvec3 v(0);
    const double step = CueAccount::kFastest_m_per_s2 * kTick_s;
    double given = 0;  // more than ten times what the account holds
    for (int k = 0; k < 8000; ++k) {
      hand.Tick(
          [&](const std::vector<dvec3>& c, const dvec3&) {
            const double side = k < 4000 ? -1 : 1;
            Move m;
            for (int i = 0; i < 3; ++i) {
              double goal = side * (c[0][i] > 0 ? 0.1 : -0.1);
              v[i] += std::clamp(goal - v[i], -step, step);
            }
            m.way_m = v * kTick_s;
            return m;
          },
          Wave(k, 60, kOblique));
      if (k == 3999) given = -hand.drawn_j;
    }
    EXPECT_GT(given, 10 * a.energy_j);
    EXPECT_LE(hand.worst_stretch_j, kRounding_j);
    EXPECT_GT(hand.drawn_j + given, 0.1 * a.energy_j);
  }
}

// Anything at all: jumps, jitter of the delay by the tick, the axis and parts of a tick, waves that
// jump too. The bound then has its term for jumps.
TEST(CueAccount, RandomHandsStayUnderTheBoundWithItsExcess) {
  double most_excess = 0, most_share = 0;
  for (uint64_t seed = 1; seed <= 400; ++seed) {
    Dice dice(seed);
    Attack a;
    a.delay = static_cast<int>(3 * dice.Uniform());
    a.energy_j = 2e-4 * dice.Uniform();
    a.power_w = dice.Uniform() < 0.5 ? 0 : 2e-3 * dice.Uniform();
    Hand hand(a);
    const double reach = kCell_m * (dice.Uniform() < 0.5 ? 1 : 30), jumps = dice.Uniform();
    const double greed = dice.Uniform();
    dvec3 wanted(0);
    for (int k = 0; k < 3000; ++k) {
      if (dice.Uniform() < 0.3) {
        wanted = dvec3(dice.Signed(), dice.Signed(), dice.Signed()) * 0.25;
      }
      hand.Tick(
          [&](const std::vector<dvec3>& c, const dvec3&) {
            Move m;
            m.late = static_cast<int>(3 * dice.Uniform());
            for (int i = 0; i < 3; ++i) {
              m.mix[i] = dice.Uniform() < 0.5 ? 0 : dice.Uniform();
              double size = reach * dice.Uniform() * (dice.Uniform() < jumps ? 1 : 0.1);
              double f = c[static_cast<size_t>(std::min(m.late, a.delay))][i];
              bool with = dice.Uniform() < greed;
              m.way_m[i] = with ? std::copysign(size, f) : size * dice.Signed();
            }
            return m;
          },
          wanted);
    }
    ASSERT_LE(hand.worst_j, kRounding_j) << seed;
    ASSERT_LE(hand.worst_stretch_j, kRounding_j) << seed;
    most_excess = std::max(most_excess, hand.most_excess_j);
    if (a.power_w == 0) most_share = std::max(most_share, hand.most_j / a.energy_j);
  }
  EXPECT_GT(most_excess, 1e-5);
  EXPECT_GT(most_share, 0.5);
}

// A hill climb: a motion of 24 ticks, repeated, and the waves with it, bent towards what draws
// more.
TEST(CueAccount, EvolvedHandsStayUnderTheBound) {
  constexpr int kPeriod = 24;
  struct Genes {
    std::array<dvec3, kPeriod> way{}, wanted{}, mix{};
    std::array<int, kPeriod> late{};
  };
  auto play = [](const Genes& g, const Attack& a) {
    Hand hand(a);
    for (int k = 0; k < 40 * kPeriod; ++k) {
      auto n = static_cast<size_t>(k % kPeriod);
      hand.Tick(
          [&](const std::vector<dvec3>&, const dvec3&) {
            return Move{g.way[n], g.mix[n], g.late[n]};
          },
          g.wanted[n]);
    }
    return hand;
  };
  double best_share = 0;
  for (int delay = 0; delay <= 2; ++delay) {
    Attack a;
    a.delay = delay;
    a.energy_j = 3e-5;
    Dice dice(77 + static_cast<uint64_t>(delay));
    Genes best;
    double best_j = -1;
    for (int round = 0; round < 1500; ++round) {
      Genes g = best;
      const bool anew = round < 40;
      for (size_t n = 0; n < kPeriod; ++n) {
        if (!anew && dice.Uniform() > 0.1) continue;
        for (int i = 0; i < 3; ++i) {
          g.way[n][i] = dice.Signed() * kCell_m * (dice.Uniform() < 0.5 ? 0.9 : 5);
          g.wanted[n][i] = dice.Signed() * 0.25;
          g.mix[n][i] = dice.Uniform();
        }
        g.late[n] = static_cast<int>((delay + 1) * dice.Uniform());
      }
      // Back to the start, so that it can repeat for ever.
      dvec3 drift(0);
      for (const dvec3& w : g.way) drift += w;
      for (dvec3& w : g.way) w -= drift / double(kPeriod);
      Hand hand = play(g, a);
      ASSERT_LE(hand.worst_j, kRounding_j) << round;
      ASSERT_LE(hand.worst_stretch_j, kRounding_j) << round;
      if (hand.most_j > best_j) {
        best_j = hand.most_j;
        best = g;
      }
    }
    best_share = std::max(best_share, best_j / a.energy_j);
    a.with_account = false;
    EXPECT_GT(play(best, a).most_j, 3 * a.energy_j);
  }
  EXPECT_GT(best_share, 0.3);
}

// A force that stops unseen: the account is empty afterwards, and in debt for the way that the tip
// may have gone under it.
TEST(CueAccount, AGapLeavesNothing) {
  CueAccountParams p;
  p.energy_j = 1e-4;
  p.tick_s = kTick_s;
  p.cell_half_m = dvec3(0.5 * kCell_m);
  CueAccount account(p);
  for (int k = 0; k < 5; ++k) account.Afford(dvec3(0), dvec3(0.1, 0, 0));
  ASSERT_GT(account.balance_j(), 0);
  account.Gap(dvec3(5 * kCell_m, 0, 0));
  EXPECT_LE(account.balance_j(), 0);
  EXPECT_EQ(account.Afford(dvec3(5 * kCell_m, 0, 0), dvec3(0.1, 0, 0)), dvec3(0));
  EXPECT_EQ(account.Afford(dvec3(5 * kCell_m, 0, 0), dvec3(0.1, 0, 0)), dvec3(0));
  account = CueAccount(p);
  for (int k = 0; k < 5; ++k) account.Afford(dvec3(0), dvec3(0.1, 0, 0));
  account.Gap(dvec3(0.1, 0, 0));
  EXPECT_LT(account.balance_j(), -0.009);  // 0.1 N over 0.1 m
}

}  // namespace
}  // namespace enamel::haptics
