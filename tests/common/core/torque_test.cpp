#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <numbers>
#include <random>
#include <vector>

#include "common/core/core.h"
#include "tests/common/core/params.h"
#include "tests/support/analytic_volume.h"

// Torque on a six-axis device: in the core, in real tissue.
namespace enamel::core {
namespace {

using test::At;

CoreParams SixAxes(uint32_t delay = 0) {
  CoreParams p = test::ParamsFor({cutting::BurShape::kCylinder, 0.6e-3, 4e-3});
  p.rotational_kc_un_m_per_rad = 800'000;
  p.peak_torque_un_m = 200'000;
  p.rotation_cell_urad = 300;
  p.bus_delay_ticks = delay;
  p.soft_start_ticks = 5;
  return p;
}

Quat Exp(const dvec3& phi) {
  const double angle = glm::length(phi);
  if (angle == 0) return {};
  const dvec3 v = phi * (std::sin(angle / 2) / angle);
  return {v.x, v.y, v.z, std::cos(angle / 2)};
}

TickInput Turned(TickInput in, const dvec3& phi) {
  in.orientation = ToQuantised(Exp(phi));
  return in;
}

// A core whose bur, upright, has been sunk `depth_m` into a block from above.
struct Seated {
  Seated(const CoreParams& params, double depth_m) : core(params, test::Block(50'000, 3e-3, 4e-3)) {
    for (int tick = 0; tick < 50; ++tick) core.Step(At(0, 0, 0.5e-3));
    const int ticks = static_cast<int>((0.5e-3 + depth_m) / 1e-6);
    for (int tick = 0; tick < ticks; ++tick) core.Step(At(0, 0, 0.5e-3 - tick * 1e-6));
    for (int tick = 0; tick < 1500; ++tick) core.Step(At(0, 0, -depth_m));
    z_m = -depth_m;
  }
  TickOutput Step(const dvec3& phi, uint8_t flags = kBurOn) {
    return core.Step(Turned(At(0, 0, z_m, flags), phi));
  }
  Core core;
  double z_m = 0;
};

// A still bur in its hole: a wall. It holds what the hand twists, up to the bound.
TEST(TorqueTest, AStillBurInItsHoleHoldsTheTwistUpToTheBound) {
  const CoreParams p = SixAxes();
  Seated s(p, 2e-3);
  TickOutput out;
  for (int mrad = 0; mrad <= 100; ++mrad) out = s.Step(dvec3(mrad * 1e-3, 0, 0), 0);
  EXPECT_NEAR(out.torque_sent_n_m.x, -0.8 * std::sin(0.1), 0.8 * 0.012);
  EXPECT_NEAR(out.torque_sent_n_m.y, 0, 0.8 * 0.003);
  for (int mrad = 100; mrad <= 400; ++mrad) out = s.Step(dvec3(mrad * 1e-3, 0, 0), 0);
  EXPECT_NEAR(glm::length(out.torque_sent_n_m), 0.2, 1e-9);
  // Turning back frees at once: never held by more than the cell on the way out.
  for (int mrad = 400; mrad >= 0; --mrad) {
    out = s.Step(dvec3(mrad * 1e-3, 0, 0), 0);
    ASSERT_LE(out.torque_sent_n_m.x, 0.8 * 300e-6) << mrad;
  }
}

TEST(TorqueTest, ATurningBurIsFeltByWhatItCutsAndLetsTheHandBackOut) {
  Seated s(SixAxes(), 2e-3);
  s.z_m = -1.85e-3;  // off the bottom, which it would go on cutting
  double most = 0;
  TickOutput out;
  for (int tick = 0; tick <= 200; ++tick) {
    out = s.Step(dvec3(tick * 0.5e-3, 0, 0));
    most = std::fmax(most, -out.torque_sent_n_m.x);
  }
  EXPECT_GT(most, 5 * 0.8 * 300e-6);
  EXPECT_GT(s.core.removed()[1], 0);
  // The hand turns back: what is stored pushes it out, nothing holds it. As far as to where the
  // wall behind begins to be felt, half a voxel before it.
  double holds = 0;
  for (int tick = 200; tick >= 40; --tick) {
    out = s.Step(dvec3(tick * 0.5e-3, 0, 0));
    holds = std::fmax(holds, out.torque_sent_n_m.x);
  }
  EXPECT_LE(holds, 0.8 * 300e-6);
}

// B_rot of the engagement, read at the pose, and the torque that falls as exp(-t K/B).
TEST(TorqueTest, AHeldTwistFallsAsTheEngagementsRotationalDampingSays) {
  CoreParams p = SixAxes();
  p.damping_mn_s_per_mm[1] = 60'000;  // so that next to nothing is cut meanwhile
  p.axial_damping_mn_s_per_mm[1] = 500;
  std::vector<double> torque;
  Seated deep(p, 1.5e-3);
  for (int tick = 0; tick < 400; ++tick) {
    torque.push_back(-deep.Step(dvec3(0.02, 0, 0)).torque_sent_n_m.x);
  }
  ASSERT_GT(torque[0], 0.5 * 0.8 * 0.02);
  cutting::EngagementReader reader(BurOf(p), 50e-6, [&] {
    cutting::TissueDamping d;
    d.lateral[1] = p.damping_mn_s_per_mm[1];
    d.axial[1] = p.axial_damping_mn_s_per_mm[1];
    return d;
  }());
  // In the first ticks the hole is the bur's own print.
  Seated same(p, 1.5e-3);
  cutting::Volume tooth = same.core.volume();
  reader.Sample(tooth, {dvec3(0, 0, -1.5e-3), Quat{}});
  const double b = reader.ReadRotational(tooth, dvec3(1, 0, 0)).damping_n_m_s.xx;
  ASSERT_GT(b, 0.01);
  for (int tick : {10, 30, 45}) {
    const double theta = 0.02 * std::exp(-tick * 1e-3 * 0.8 / b);
    EXPECT_NEAR(torque[static_cast<size_t>(tick)], 0.8 * theta, 0.15 * 0.8 * theta) << tick;
  }
}

TEST(TorqueTest, IsZeroWhereverForceIsOff) {
  Seated s(SixAxes(), 2e-3);
  auto twisted = [&] {
    TickOutput out;
    for (int i = 0; i < 60; ++i) out = s.Step(dvec3(i * 1e-3, 0, 0), 0);
    return out;
  };
  EXPECT_GT(glm::length(twisted().torque_sent_n_m), 0.02);
  TickOutput out = s.Step(dvec3(0.06, 0, 0), kFaulted);
  EXPECT_EQ(glm::length(out.torque_sent_n_m), 0);
  // Suspended since, in the tooth; and once it has come out, with nothing stored.
  for (int i = 0; i < 20; ++i) {
    out = s.Step(dvec3(0.06, 0, 0), 0);
    ASSERT_TRUE(out.flags & kSuspended);
    ASSERT_EQ(glm::length(out.torque_sent_n_m), 0);
  }
  s.z_m = 1e-3;
  for (int i = 0; i < 20; ++i) {
    out = s.Step(dvec3(0.06, 0, 0), 0);
    ASSERT_LE(glm::length(out.torque_sent_n_m), 0.8 * 300e-6);
  }
  EXPECT_FALSE(out.flags & kSuspended);
  s.z_m = -2e-3;
  out = s.Step(dvec3(0.06, 0, 0), kSoftRestart);
  EXPECT_EQ(glm::length(out.torque_sent_n_m), 0);
}

TEST(TorqueTest, AGapTakesTheTorqueAwayUntilTheHandIsBackAndALongTurnSuspends) {
  Seated s(SixAxes(), 2e-3);
  TickOutput out;
  for (int i = 0; i <= 60; ++i) out = s.Step(dvec3(i * 1e-3, 0, 0), 0);
  const double before = glm::length(out.torque_sent_n_m);
  ASSERT_GT(before, 0.02);
  TickInput in = Turned(At(0, 0, -2e-3, 0), dvec3(0.061, 0, 0));
  in.gap_ticks = 3;
  out = s.core.Step(in);
  EXPECT_FALSE(out.flags & kSuspended);
  EXPECT_EQ(glm::length(out.torque_sent_n_m), 0);
  EXPECT_LT(2 * std::fabs(out.anchor.orientation.x), 0.02);
  EXPECT_EQ(glm::length(s.Step(dvec3(0.061, 0, 0), 0).torque_sent_n_m), 0);
  for (int i = 61; i >= 0; --i) s.Step(dvec3(i * 1e-3, 0, 0), 0);
  for (int i = 0; i <= 30; ++i) out = s.Step(dvec3(i * 1e-3, 0, 0), 0);
  EXPECT_GT(glm::length(out.torque_sent_n_m), 0.01);
  // A gap over which the torque was held is only time.
  in = Turned(At(0, 0, -2e-3, 0), dvec3(0.031, 0, 0));
  in.gap_ticks = 1;
  in.flags |= kHeldGap | kLateTick;
  EXPECT_GT(glm::length(s.core.Step(in).torque_sent_n_m), 0.01);
  in = Turned(At(0, 0, -2e-3, 0), dvec3(0.2, 0, 0));
  in.gap_ticks = 3;
  EXPECT_TRUE(s.core.Step(in).flags & kSuspended);
}

// Torques that differ by less than the witness holds, or by nothing that it holds: the hash knows.
TEST(TorqueTest, TheHashCoversTheTorque) {
  CoreParams p = SixAxes(), q = SixAxes();
  q.peak_torque_un_m = 150'000;
  Seated a(p, 2e-3), b(q, 2e-3);
  for (int i = 0; i <= 300; ++i) {
    const TickOutput x = a.Step(dvec3(i * 1e-3, 0, 0), 0), y = b.Step(dvec3(i * 1e-3, 0, 0), 0);
    ASSERT_EQ(x.witness, y.witness);
    if (i == 100) {
      ASSERT_EQ(a.core.state_hash(), b.core.state_hash());
    }
  }
  EXPECT_NE(a.core.state_hash(), b.core.state_hash());
}

// The theorem with the product's own core and tooth: a hostile hand turns the bur in a tooth that
// it cuts, pedal on and off, and gets back no more than was stored. The device's b and c are the
// least that its profile may have.
struct Thief {
  explicit Thief(uint32_t delay, double too_stiff = 1)
      : params(ParamsWith(delay, too_stiff)), core(params, test::Block(100'000, 2e-3, 3e-3)) {
    k = 0.8;
    const double held = delay + 1;
    b_over_t = 0.5 * k * held * held;
    c = k * 300e-6;
    stored = 0.5 * k * too_stiff * 300e-6 * 300e-6;
    under_way.assign(delay, dvec3(0));
  }
  static CoreParams ParamsWith(uint32_t delay, double too_stiff) {
    CoreParams p = SixAxes(delay);
    p.rotational_kc_un_m_per_rad = static_cast<int32_t>(800'000 * too_stiff);
    return p;
  }
  // Reading off by at most 300 - 62 urad, and the recording's own rounding.
  void Tick(const dvec3& at_m, const dvec3& off, const dvec3& phi, bool greedy, uint8_t flags,
            uint32_t gap = 0) {
    TickInput in = At(at_m.x, at_m.y, at_m.z, flags);
    in.orientation = ToQuantised(Exp(off * 238e-6) * x);
    in.gap_ticks = gap;
    const TickOutput out = core.Step(in);
    // Every time the torque comes on it may have half a cell's energy.
    const bool off_now = gap > 0 || (out.flags & kSuspended) != 0;
    if (off_now) was_off = true;
    if (!off_now && was_off) {
      floor -= stored;
      was_off = false;
    }
    Turn(out.torque_sent_n_m, phi, greedy);
    if (gap > 0) Turn(dvec3(0), phi, false);
  }
  void Turn(const dvec3& torque, dvec3 phi, bool greedy) {
    under_way.push_back(torque);
    const dvec3 felt = under_way.front();
    under_way.pop_front();
    const double size = glm::length(felt);
    if (greedy) phi = size > c ? felt * ((size - c) / (2 * b_over_t * size)) : dvec3(0);
    const double way = glm::length(phi);
    balance += -Dot(felt, phi) + b_over_t * way * way + c * way;
    x = (Exp(phi) * x).Normalised();
    lowest = std::fmin(lowest, balance - floor);
    most = std::fmax(most, size);
  }

  const CoreParams params;
  Core core;
  double k, b_over_t, c, stored;
  Quat x;
  std::deque<dvec3> under_way;
  bool was_off = true;
  double balance = 0, floor = 0, lowest = 0, most = 0;
};

double Steal(Thief& thief, unsigned seed) {
  std::mt19937_64 random(seed);
  auto uniform = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
  auto direction = [&] {
    std::normal_distribution<double> normal;
    return glm::normalize(dvec3(normal(random), normal(random), normal(random)));
  };
  for (int i = 0; i < 10; ++i) thief.Tick(dvec3(0, 0, 1e-3), dvec3(0), dvec3(0), false, kBurOn);
  double z = 1e-3;
  for (int i = 0; i < 1000; ++i) {
    thief.Tick(dvec3(0, 0, z), dvec3(0), dvec3(0), false, kBurOn);
    z = std::fmax(-1.2e-3, z - 3e-6);
  }
  const unsigned trick = seed % 6;
  dvec3 axis = direction();
  axis.z *= 0.2;
  axis = glm::normalize(axis);
  for (int i = 0; i < 1200; ++i) {
    uint8_t flags = kBurOn;
    dvec3 off = direction(), phi(0);
    bool greedy = false;
    uint32_t gap = 0;
    switch (trick) {
      case 0:  // a cell's edge, wall and tissue in turn
        flags = i % 2 ? kBurOn : 0;
        phi = axis * (i % 2 ? 100e-6 : -100e-6);
        off = axis * (i % 2 ? 1.0 : -1.0);
        break;
      case 1:
        phi = axis * (2e-3 * std::sin(i * 0.05));
        flags = i / 30 % 2 ? kBurOn : 0;
        break;
      case 2:
        greedy = i % 3 == 0;
        phi = greedy ? dvec3(0) : direction() * 0.01 * uniform();
        flags = uniform() < 0.5 ? kBurOn : 0;
        break;
      case 3:  // in and out of the tooth, and half turns outside
        z += 4e-6 * (i / 300 % 2 ? -1 : 1);
        phi = i % 300 == 299 ? axis * std::numbers::pi * uniform() : axis * 1e-3 * uniform();
        greedy = i % 5 == 0;
        break;
      case 4:  // gaps
        gap = i % 40 == 0 ? 1 + static_cast<uint32_t>(3 * uniform()) : 0;
        phi = axis * (1e-3 * (i / 20 % 2 ? 1 : -1));
        greedy = gap > 0;
        flags = 0;
        break;
      case 5:
        greedy = true;
        off = axis * (i % 2 ? 1.0 : -1.0);
        flags = i % 2 ? 0 : kBurOn;
        break;
    }
    thief.Tick(dvec3(0, 0, z), off, phi, greedy, flags, gap);
  }
  return thief.lowest;
}

TEST(TorqueTest, NoHandGetsMoreOutOfTheToothThanWasStored) {
  for (uint32_t delay = 0; delay <= 2; ++delay) {
    for (unsigned seed = 0; seed < 12; ++seed) {
      Thief thief(delay);
      EXPECT_GE(Steal(thief, seed), -1e-12) << "delay " << delay << ", seed " << seed;
      EXPECT_LE(thief.most, 0.2 * (1 + 1e-12));
    }
  }
}

TEST(TorqueTest, ASpringTenTimesTooStiffIsPumpedByTheSameHands) {
  double lowest = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    Thief thief(0, 10);
    lowest = std::fmin(lowest, Steal(thief, seed));
  }
  EXPECT_LT(lowest, -1e-5);
}

TEST(TorqueTest, WildInputsStayBoundedInTorqueAndWork) {
  CoreParams p = SixAxes(1);
  Core core(p, test::Block(100'000, 2e-3, 2e-3));
  std::mt19937_64 random(3);
  double most = 0;
  for (int tick = 0; tick < 600; ++tick) {
    TickInput in = At(0, 0, tick < 20 ? 2e-3 : -0.2e-3 * (tick % 5));
    for (auto& q : in.orientation) q = static_cast<int16_t>(tick % 3 ? random() : 3000);
    in.flags = static_cast<uint8_t>(tick < 20 || tick % 2 ? int{kBurOn} : random() & 3);
    in.gap_ticks = random() % 10 == 0 && tick > 20 ? static_cast<uint32_t>(random()) : 0;
    const TickOutput out = core.Step(in);
    most = std::fmax(most, glm::length(out.torque_sent_n_m));
    ASSERT_LE(core.work().moves, Core::kMaxMovesPerTick);
    ASSERT_LE(core.work().cuts, Core::kMaxCutsPerTick);
  }
  EXPECT_LE(most, 0.2 * (1 + 1e-12));
  EXPECT_GT(most, 0.1);
}

}  // namespace
}  // namespace enamel::core
