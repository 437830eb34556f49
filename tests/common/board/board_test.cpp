#include "common/board/board.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <vector>

#include "tests/support/dice.h"

// The reference firmware against hands and hosts that want its energy, in a bookkeeping of this
// file's own: the tip's true way, the force that its motors hold, and nothing of the firmware's but
// the force it returns.
namespace enamel {
namespace {

using testing_support::Dice;

constexpr double kTick_s = 1 / 8000.0;
constexpr int kTicksPerMs = 8;

// The paper's devices at 8 kHz, Kc by friction: 2c/delta.
struct Device {
  const char* name;
  double b_n_s_per_m, kc_n_per_m, cell_m, peak_n;
};
constexpr std::array<Device, 3> kDevices = {{{"Omega", 6, 20e3, 9e-6, 12},
                                             {"Phantom", 1.75, 5e3, 10e-6, 7.9},
                                             {"BHhd", 2.5, 8e3, 20e-6, 10}}};

dvec3 Of(const EnVec& v) { return {v.x, v.y, v.z}; }
EnVec Of(const dvec3& v) { return {v.x, v.y, v.z}; }
double Length(const dvec3& v) { return std::sqrt(Dot(v, v)); }

// The paper's devices at 1 kHz: Kc that damping pays for with a tick of delay.
constexpr double kSlowTick_s = 1e-3;
constexpr std::array<Device, 3> kSlowDevices = {{{"Omega", 6, 3e3, 9e-6, 12},
                                                 {"Phantom", 1.75, 0.875e3, 10e-6, 7.9},
                                                 {"BHhd", 2.5, 1.25e3, 20e-6, 10}}};

// A board on a device: cells, delay, friction at the limit of the clause, and the theorem's sum.
class Rig {
 public:
  Rig(const Device& device, int delay, double damping_share = 1, double tick_s = kTick_s)
      : device_(device), under_way_(static_cast<size_t>(delay), dvec3(0)) {
    EnBoardParams params{};
    params.tick_s = tick_s;
    params.delay_ticks = delay;
    params.kc_n_per_m = device.kc_n_per_m;
    params.cell.half_m = {device.cell_m / 2, device.cell_m / 2, device.cell_m / 2};
    params.peak_n = device.peak_n;
    params.damping_n_s_per_m = device.b_n_s_per_m;
    EXPECT_TRUE(EnBoardStart(&board, &params));
    b_over_t_ = damping_share * device.b_n_s_per_m / tick_s;
  }

  dvec3 Reading() const { return (glm::floor(x / device_.cell_m) + 0.5) * device_.cell_m; }
  // Reads, and holds the force of `delay` ticks ago while the tip goes to `next`.
  dvec3 Tick(const dvec3& next) {
    const bool ran = board.running;
    const dvec3 force = Of(EnBoardTick(&board, Of(Reading())));
    if (board.running && !ran) {
      const dvec3 e = x - Reading();
      floor_j -= 0.5 * device_.kc_n_per_m * Dot(e, e);
    }
    under_way_.push_back(force);
    const dvec3 felt = under_way_.front(), way = next - x;
    under_way_.pop_front();
    balance_j += -Dot(felt, way) + b_over_t_ * Dot(way, way) +
                 0.5 * device_.kc_n_per_m * device_.cell_m *
                     (std::fabs(way.x) + std::fabs(way.y) + std::fabs(way.z));
    lowest_j = std::min(lowest_j, balance_j - floor_j);
    x = next;
    return force;
  }
  // Whatever came before, as the clause's cell has it, N.
  double Hidden(const dvec3& force) const {
    const double length = Length(force);
    if (length == 0) return 0;
    return 0.5 * device_.kc_n_per_m * device_.cell_m *
           (std::fabs(force.x) + std::fabs(force.y) + std::fabs(force.z)) / length;
  }

  EnBoard board;
  dvec3 x{0};
  double balance_j = 0, floor_j = 0, lowest_j = 0;

 private:
  const Device& device_;
  std::deque<dvec3> under_way_;
  double b_over_t_ = 0;
};

EnCommand Wish(const dvec3& rest, double bound_n = 1e3) {
  EnCommand c{};
  c.motors_on = c.spring_on = true;
  c.rest_m = Of(rest);
  c.share = 1;
  c.bound_n = bound_n;
  return c;
}

// A hand without scruples: steps of any length, with or against the force, or none.
dvec3 HostileStep(Dice& dice, const dvec3& x, const dvec3& force, double cell) {
  const double reach = cell * std::pow(10.0, -2 + 3 * dice.Uniform());
  const double f = Length(force);
  switch (dice.Below(4)) {
    case 0:
      return x;
    case 1:
      return f > 0 ? x + force * (reach / f) : x;
    case 2:
      return f > 0 ? x - force * (reach / f) : x;
    default:
      return x + dice.Direction() * reach;
  }
}

// A host without sense: any rest point near, any bound, follow, off, late, or nothing.
void HostileHost(Dice& dice, const Device& device, Rig& rig, uint32_t& sequence) {
  if (dice.Below(3) == 0) return;
  const double reach = device.peak_n / device.kc_n_per_m;
  EnCommand c = Wish(rig.x + dice.Direction() * (reach * dice.Uniform()));
  // Not under what the guard may leave: below it the share falls, which with delay gives back as
  // guard.h says.
  c.bound_n = device.kc_n_per_m * EnRadius(&rig.board.params.cell) * (2 + 8 * dice.Uniform());
  c.follow = dice.Below(4) == 0;
  c.spring_on = dice.Below(200) != 0;
  const uint32_t old = static_cast<uint32_t>(dice.Below(8) == 0 ? dice.Below(40) : 0);
  EnBoardObey(&rig.board, &c, ++sequence - old);
}

TEST(BoardTest, AKcThatTheDampingDoesNotPayForIsRefused) {
  EnBoard board;
  EnBoardParams p{};
  p.tick_s = kTick_s;
  p.delay_ticks = 1;
  p.cell.half_m = {1e-6, 1e-6, 1e-6};
  p.peak_n = 1;
  p.damping_n_s_per_m = 6;
  EXPECT_DOUBLE_EQ(EnLargestKc(6, kTick_s, 1), 24e3);
  p.kc_n_per_m = 24.001e3;
  EXPECT_FALSE(EnBoardStart(&board, &p));
  EnCommand c = Wish(dvec3(1e-3));
  EnBoardObey(&board, &c, 1);
  EXPECT_EQ(Of(EnBoardTick(&board, {0, 0, 0})), dvec3(0));
  p.kc_n_per_m = 24e3;
  EXPECT_TRUE(EnBoardStart(&board, &p));
  for (double EnBoardParams::*number :
       {&EnBoardParams::tick_s, &EnBoardParams::kc_n_per_m, &EnBoardParams::peak_n,
        &EnBoardParams::damping_n_s_per_m}) {
    for (double bad : {0.0, -1.0, std::nan("")}) {
      EnBoardParams q = p;
      q.*number = bad;
      EXPECT_FALSE(EnBoardStart(&board, &q)) << bad;
    }
  }
}

TEST(BoardTest, NoHandAndNoHostDrawEnergyFromTheSpring) {
  for (const Device& device : kDevices) {
    for (int delay : {0, 1}) {
      for (uint64_t seed = 1; seed <= 40; ++seed) {
        Dice dice(seed);
        Rig rig(device, delay);
        uint32_t sequence = 0;
        dvec3 force(0);
        for (int k = 0; k < 8000; ++k) {
          if (k % kTicksPerMs == 0) HostileHost(dice, device, rig, sequence);
          force = rig.Tick(HostileStep(dice, rig.x, force, device.cell_m));
          ASSERT_LE(Length(force), device.peak_n * (1 + 1e-12));
        }
        EXPECT_GE(rig.lowest_j, -1e-12) << device.name << ", delay " << delay << ", seed " << seed;
      }
    }
  }
}

// The floor is the clause's, not this test's generosity.
TEST(BoardTest, WithAFifthOfTheDampingAHandDrawsEnergy) {
  const Device& device = kDevices[0];
  double lowest_j = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    Dice dice(seed);
    Rig rig(device, 1, 0.2);
    const EnCommand c = Wish(dvec3(0.2e-3, 0, 0));
    for (int k = 0; k < 4000; ++k) {
      if (k % kTicksPerMs == 0) EnBoardObey(&rig.board, &c, static_cast<uint32_t>(k + 1));
      // Round in six ticks: the force lags by a quarter of that.
      rig.Tick(dvec3(0.2e-3 + 50e-6 * std::sin(k * M_PI / 3) + 1e-6 * dice.Uniform(), 0, 0));
    }
    lowest_j = std::min(lowest_j, rig.lowest_j);
  }
  EXPECT_LT(lowest_j, -1e-6);
}

TEST(BoardTest, AHostCutForASecondAtAnyTickLeavesTheBalanceAndEndsBelowTheCell) {
  for (const Device& device : kDevices) {
    for (int delay : {0, 1}) {
      for (uint64_t seed = 1; seed <= 24; ++seed) {
        Dice dice(seed);
        Rig rig(device, delay);
        uint32_t sequence = 0;
        dvec3 force(0);
        const int cut = 1 + dice.Below(4000), back = cut + 1000 * kTicksPerMs;
        for (int k = 0; k < back + 2000; ++k) {
          const bool heard = k % kTicksPerMs == 0 && (k < cut || k > back);
          // Presses, so that there is a force to be left alone with.
          if (heard && k < cut && k % 64 == 0) {
            EnCommand c = Wish(rig.x - dvec3(0.3 * device.peak_n / device.kc_n_per_m, 0, 0));
            EnBoardObey(&rig.board, &c, ++sequence);
          } else if (heard) {
            HostileHost(dice, device, rig, sequence);
          }
          force = rig.Tick(HostileStep(dice, rig.x, force, device.cell_m));
          if (k == back) {
            EXPECT_LE(Length(force), rig.Hidden(force) * (1 + 1e-9))
                << device.name << ", delay " << delay << ", seed " << seed;
          }
        }
        EXPECT_GE(rig.lowest_j, -1e-12) << device.name << ", delay " << delay << ", seed " << seed;
      }
    }
  }
}

TEST(BoardTest, ALostHostsForceOnlyFalls) {
  const Device& device = kDevices[0];
  Rig rig(device, 1);
  // The hand goes in from the rest point: 3 N without help of a tank.
  const EnCommand c = Wish(rig.Reading());
  dvec3 force(0);
  for (int k = 0; k < 400; ++k) {
    if (k % kTicksPerMs == 0) EnBoardObey(&rig.board, &c, static_cast<uint32_t>(k + 1));
    force = rig.Tick(rig.x + dvec3(0.375e-6, 0, 0));
  }
  const double last = Length(force);
  ASSERT_NEAR(last, 3, 0.2);
  // It pushes on, and does not get more force.
  double most = last + 0.375e-6 * kTicksPerMs * device.kc_n_per_m * 4, at_half = 0;
  for (int k = 1; k <= 3 * 8000 + 8; ++k) {
    force = rig.Tick(rig.x + dvec3(0.05e-6, 0, 0));
    EXPECT_LE(Length(force), most);
    if (k > 3 * kTicksPerMs) most = last;
    if (k == 2000) at_half = Length(force);
    if (k == 4008) EXPECT_LE(Length(force), rig.Hidden(force) * (1 + 1e-9));
  }
  EXPECT_NEAR(at_half, last / 2, 0.1 * last);
  EXPECT_FALSE(EnBoardDrives(&rig.board));
  EXPECT_EQ(force, dvec3(0));
}

TEST(BoardTest, InAirNothingDragsThoughTheHostIsLateOrLost) {
  for (const Device& device : kDevices) {
    for (int delay : {0, 1}) {
      Rig rig(device, delay);
      EnCommand c = Wish(dvec3(0));
      c.follow = true;
      double most_n = 0;
      uint32_t sequence = 0;
      const dvec3 way = dvec3(0.6, 0.64, 0.48) * (50e-3 * kTick_s);
      // On time for a second, then two of three reports late, then lost for two and a half seconds.
      for (int k = 0; k < 8000 * 4.5; ++k) {
        const int every = k < 8000 ? 1 : 3;
        if (k < 16000 && k % (every * kTicksPerMs) == 0) EnBoardObey(&rig.board, &c, ++sequence);
        most_n = std::max(most_n, Length(rig.Tick(rig.x + way)));
      }
      EXPECT_LE(most_n, 0.3) << device.name << ", delay " << delay;
      EXPECT_TRUE(EnBoardDrives(&rig.board));
      ::testing::Test::RecordProperty(device.name, std::to_string(most_n));
    }
  }
}

TEST(BoardTest, AHostThatReturnsFindsTheSpringAsItIsAndIsGrantedNothing) {
  const Device& device = kDevices[1];
  for (int silent_ms : {1, 4, 20, 400, 900, 2900}) {
    Rig rig(device, 1);
    const EnCommand c = Wish(rig.Reading());
    for (int k = 0; k < 800; ++k) {
      if (k % kTicksPerMs == 0)
        EnBoardObey(&rig.board, &c, static_cast<uint32_t>(500 + k / kTicksPerMs));
      rig.Tick(rig.x + dvec3(0.5e-6, 0, 0));
    }
    dvec3 force(0);
    for (int k = 0; k < silent_ms * kTicksPerMs; ++k) force = rig.Tick(rig.x);
    EnPoseReport told{};
    EnBoardTell(&rig.board, &told);
    const double energy = rig.board.spring.tank.energy_j, share = rig.board.spring.share;
    EXPECT_NEAR(told.rest_nm[0] * 1e-9, rig.board.spring.rest_m.x, 0.51e-9);
    EXPECT_EQ(told.share, 65535);
    // A restarted host counts from 1; after a silence that is in order.
    const EnCommand back = Wish(dvec3(told.rest_nm[0], told.rest_nm[1], told.rest_nm[2]) * 1e-9);
    EXPECT_EQ(EnBoardObey(&rig.board, &back, 1), silent_ms >= 3) << silent_ms;
    const dvec3 next = rig.Tick(rig.x);
    EXPECT_LE(Length(next - force), 1e-9 * device.kc_n_per_m + 1e-9 * device.peak_n) << silent_ms;
    EXPECT_LE(rig.board.spring.tank.energy_j, energy + 1e-12);
    EXPECT_LE(rig.board.spring.share, share + 1e-12);
  }
}

TEST(BoardTest, WhatDoesNotCountLeavesTheSpringAsItIs) {
  const Device& device = kDevices[2];
  Rig rig(device, 1);
  const EnCommand good = Wish(rig.Reading());
  ASSERT_TRUE(EnBoardObey(&rig.board, &good, 1000));
  for (int k = 0; k < 16; ++k) rig.Tick(rig.x + dvec3(2e-6, 0, 0));
  const dvec3 before = Of(rig.board.felt_n);
  ASSERT_GT(Length(before), 0.1);
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (double bad : {nan, inf, -inf, 1e300}) {
    EnCommand c = good;
    c.rest_m.y = bad;
    EXPECT_FALSE(EnBoardObey(&rig.board, &c, 1001));
    c = good;
    c.added_n.z = bad;
    EXPECT_FALSE(EnBoardObey(&rig.board, &c, 1001));
    c = good;
    c.cell.ball_m = bad;
    EXPECT_FALSE(bad < 1e299 && EnBoardObey(&rig.board, &c, 1001));
  }
  for (double EnCommand::*number : {&EnCommand::share, &EnCommand::bound_n}) {
    EnCommand c = good;
    c.*number = nan;
    EXPECT_FALSE(EnBoardObey(&rig.board, &c, 1001));
  }
  // Doubled, late, and the most that is late.
  EnCommand far = Wish(dvec3(1));
  for (uint32_t late : {1000u, 999u, 1u, 0u}) EXPECT_FALSE(EnBoardObey(&rig.board, &far, late));
  rig.Tick(rig.x);
  EXPECT_EQ(Of(rig.board.felt_n), before);
}

// Builds a report of bytes apart from the station's encoder.
std::vector<uint8_t> SpringBytes(uint8_t version, uint8_t flags, uint32_t sequence) {
  std::vector<uint8_t> b(kEnSpringBytes);
  b[0] = kEnSpringId;
  b[1] = version;
  b[2] = flags;
  for (size_t i = 0; i < 4; ++i) b[4 + i] = static_cast<uint8_t>(sequence >> (8 * i));
  b[32] = b[33] = b[34] = b[35] = 0xFF;
  const uint16_t crc = EnCrc16(b.data(), b.size() - 2);
  b[54] = static_cast<uint8_t>(crc);
  b[55] = static_cast<uint8_t>(crc >> 8);
  return b;
}

TEST(BoardTest, AReportOfAnotherVersionIsAsIfItHadNotCome) {
  const Device& device = kDevices[0];
  for (int silent_ms : {1, 3, 10, 100, 1000, 2999, 10'000}) {
    Rig rig(device, 1);
    auto good = SpringBytes(1, 3, 7);
    ASSERT_TRUE(EnBoardReceive(&rig.board, good.data(), good.size()));
    dvec3 force(0);
    // Reports of version 2 with the motors off come all the time.
    for (int k = 0; k < silent_ms * kTicksPerMs; ++k) {
      if (k % kTicksPerMs == 0) {
        auto other = SpringBytes(2, 0, 8 + static_cast<uint32_t>(k));
        EXPECT_FALSE(EnBoardReceive(&rig.board, other.data(), other.size()));
      }
      // Within the peak of the spring; then it stays.
      force = rig.Tick(rig.x + dvec3(k < 800 ? 0.1e-6 : 0, 0, 0));
      ASSERT_LE(Length(force), device.peak_n);
    }
    EXPECT_EQ(EnBoardDrives(&rig.board), silent_ms < 3000) << silent_ms;
    if (silent_ms >= 1000) EXPECT_LE(Length(force), rig.Hidden(force) * (1 + 1e-9)) << silent_ms;
  }
}

TEST(BoardTest, AForceReportTurnsTheSpringOffAndADamagedOneDoesNot) {
  Rig rig(kDevices[0], 1);
  auto good = SpringBytes(1, 3, 7);
  ASSERT_TRUE(EnBoardReceive(&rig.board, good.data(), good.size()));
  for (int k = 0; k < 8; ++k) rig.Tick(rig.x + dvec3(5e-6, 0, 0));
  EXPECT_TRUE(rig.board.running);
  auto bad = SpringBytes(1, 0, 8);
  bad[2] ^= 4;
  EXPECT_FALSE(EnBoardReceive(&rig.board, bad.data(), bad.size()));
  EXPECT_FALSE(EnBoardReceive(&rig.board, good.data(), 20));
  rig.Tick(rig.x);
  EXPECT_TRUE(rig.board.running);
  std::vector<uint8_t> force(kEnForceBytes);
  force[0] = kEnForceId;
  force[1] = kEnReportVersion;
  force[2] = 1;
  force[4] = 8;
  const uint16_t crc = EnCrc16(force.data(), force.size() - 2);
  force[34] = static_cast<uint8_t>(crc);
  force[35] = static_cast<uint8_t>(crc >> 8);
  EXPECT_TRUE(EnBoardReceive(&rig.board, force.data(), force.size()));
  rig.Tick(rig.x);
  EXPECT_FALSE(rig.board.running);
  EXPECT_EQ(Of(rig.board.felt_n), dvec3(0));
}

TEST(BoardTest, TheHostsForceIsAddedWithinThePeakAndEndsWithTheHost) {
  const Device& device = kDevices[0];
  Rig rig(device, 0);
  EnCommand c = Wish(dvec3(0));
  c.follow = true;
  c.added_n = {100, 0, 0};
  dvec3 force(0);
  for (uint32_t ms = 1; ms <= 4; ++ms) {
    ASSERT_TRUE(EnBoardObey(&rig.board, &c, ms));
    for (int k = 0; k < kTicksPerMs; ++k) {
      const dvec3 next = rig.Tick(rig.x);
      EXPECT_LE(Length(next - force), 4000 * kTick_s * (1 + 1e-9));
      force = next;
    }
  }
  EXPECT_NEAR(Length(force), device.peak_n, 1e-9);
  // Lost after 3 ms, and at 0 no later than the peak takes at 4000 N/s, 3 ms.
  for (int k = 0; k < 7 * kTicksPerMs; ++k) {
    const dvec3 next = rig.Tick(rig.x);
    EXPECT_LE(Length(next - force), 4000 * kTick_s * (1 + 1e-9));
    force = next;
  }
  EXPECT_LE(Length(force), 0.1);
}

// The change of the spring's force in a tick of length T that board.h allows; the cell is a cube.
double MostChange_n(const Device& device, const dvec3& way, double tick_s) {
  const double radius_m = std::sqrt(3.0) * device.cell_m / 2;
  return device.kc_n_per_m * (Length(way) + 2 * radius_m) + 100 * tick_s;
}

// How far `before` is from the forces that shrink to `after`: t * after with t of 1 and more.
double OffItsOwnLine_n(const dvec3& before, const dvec3& after) {
  const double square = Dot(after, after);
  const double t = square > 0 ? std::max(1.0, Dot(before, after) / square) : 1;
  return Length(square > 0 ? before - after * t : dvec3(0));
}

// One that knows the rule and looks for a way around it: rest points on every side and far beyond the
// peak, cells named too large; with `bounds_jump` also bounds and shares that jump, spring off and on.
EnCommand ArtfulWish(Dice& dice, const Device& device, const Rig& rig, bool bounds_jump) {
  EnCommand c = Wish(rig.x + dice.Direction() * (std::pow(10.0, 4 * dice.Uniform() - 3) *
                                                 device.peak_n / device.kc_n_per_m));
  c.follow = dice.Below(6) == 0;
  if (dice.Below(3) == 0) {
    for (EnVec& edge : c.cell.joint_half_m) edge = Of(dice.Direction() * (32e-6 * dice.Uniform()));
  }
  if (!bounds_jump) return c;
  if (dice.Below(3) == 0) c.bound_n = device.peak_n * dice.Uniform();
  if (dice.Below(3) == 0) c.share = dice.Below(3) * 0.5 * dice.Uniform();
  c.spring_on = dice.Below(30) != 0;
  return c;
}

struct Pace {
  double tick_s;
  int report_every;
  const std::array<Device, 3>& devices;
};
const std::array<Pace, 2> kPaces = {
    {{kTick_s, kTicksPerMs, kDevices}, {kSlowTick_s, 1, kSlowDevices}}};

// Plays an artful host and a hostile hand, and calls `check` at each tick with the force before and now
// and the way of the reading. With `bounds_jump` reports are missing, too, and the host counts as lost.
template <typename Check>
void PlayArtfulHost(const Pace& pace, const Device& device, uint64_t seed, bool bounds_jump,
                    Check check) {
  Dice dice(seed);
  Rig rig(device, static_cast<int>(seed % 2), 1, pace.tick_s);
  dvec3 force(0), reading(0);
  uint32_t sequence = 0;
  bool on = false;
  for (int k = 0; k < 3000; ++k) {
    if (k % pace.report_every == 0 && (!bounds_jump || dice.Below(4) != 0)) {
      const EnCommand c = ArtfulWish(dice, device, rig, bounds_jump);
      ASSERT_TRUE(EnBoardObey(&rig.board, &c, ++sequence));
      on = c.spring_on;
    }
    const dvec3 way = rig.Reading() - reading;
    reading = rig.Reading();
    // A firm hand half of the time: it makes the spring long, and fills the tank.
    const dvec3 next = k / 100 % 2 == 0 ? HostileStep(dice, rig.x, force, device.cell_m)
                                        : rig.x + dice.Direction() * (0.5 * device.cell_m);
    const dvec3 now = rig.Tick(next);
    if (on) check(force, now, way);
    force = now;
  }
  EXPECT_GE(rig.lowest_j, -1e-12) << device.name << ", seed " << seed;
}

TEST(BoardTest, NoHostChangesTheForceFasterThanTheHandAndTheStatedRate) {
  for (const Pace& pace : kPaces) {
    double most_share = 0;
    for (const Device& device : pace.devices) {
      for (uint64_t seed = 1; seed <= 30; ++seed) {
        PlayArtfulHost(pace, device, seed, false, [&](auto& before, auto& now, auto& way) {
          const double most = MostChange_n(device, way, pace.tick_s);
          ASSERT_LE(Length(now - before), most * (1 + 1e-9)) << device.name << ", seed " << seed;
          most_share = std::max(most_share, Length(now - before) / most);
        });
      }
    }
    EXPECT_GT(most_share, 0.999) << "the host comes to the bound";
  }
}

TEST(BoardTest, WhatAHostsBoundOrShareTakesAwayShrinksAlongItselfAndReturnsNoFaster) {
  int fell = 0;
  for (const Pace& pace : kPaces) {
    for (const Device& device : pace.devices) {
      for (uint64_t seed = 1; seed <= 30; ++seed) {
        PlayArtfulHost(pace, device, seed, true, [&](auto& before, auto& now, auto& way) {
          const double most = MostChange_n(device, way, pace.tick_s);
          ASSERT_LE(OffItsOwnLine_n(before, now), most * (1 + 1e-9))
              << device.name << ", seed " << seed;
          fell += Length(now - before) > most;
        });
      }
    }
  }
  EXPECT_GT(fell, 100) << "the host lowers its bound";
}

// A tank filled by a hand that has pressed and been let go: enough for half of the peak.
Rig FullRig(const Device& device) {
  Rig rig(device, 0);
  uint32_t sequence = 0;
  const EnCommand hold = Wish(rig.Reading());
  const double goes_in_m = 0.9 * device.peak_n / device.kc_n_per_m;
  for (int k = 0; k < 400; ++k) {
    if (k % kTicksPerMs == 0) EnBoardObey(&rig.board, &hold, ++sequence);
    rig.Tick(dvec3(goes_in_m * std::min(1.0, k / 300.0), 0, 0));
  }
  EnCommand air = hold;
  air.follow = true;
  EnBoardObey(&rig.board, &air, ++sequence);
  for (int k = 0; k < 2 * 100; ++k) rig.Tick(rig.x);
  return rig;
}

// The way that a board without the bound goes in 125 us.
TEST(BoardTest, AWishOfHalfThePeakIsReachedInStepsOfTheBoundAndNoSlower) {
  for (const Device& device : kDevices) {
    Rig rig = FullRig(device);
    const double wish_n = 0.44 * device.peak_n;
    const dvec3 rest = rig.Reading() - dvec3(wish_n / device.kc_n_per_m, 0, 0);
    const double most = MostChange_n(device, dvec3(0), kTick_s);
    const int ticks = static_cast<int>(std::ceil(2 * wish_n / most)) + 1;
    dvec3 force = rig.Tick(rig.x);
    double steepest_n = 0;
    for (int k = 0; k < ticks; ++k) {
      const EnCommand c = Wish(rest);
      ASSERT_TRUE(EnBoardObey(&rig.board, &c, static_cast<uint32_t>(10'000 + k)));
      const dvec3 next = rig.Tick(rig.x);
      steepest_n = std::max(steepest_n, Length(next - force));
      force = next;
    }
    EXPECT_NEAR(force.x, -wish_n, 0.01 * wish_n) << device.name;
    EXPECT_LE(steepest_n, most * (1 + 1e-9)) << device.name;
    ::testing::Test::RecordProperty(device.name, std::to_string(steepest_n) + " N a tick");
  }
}

// A law at 1 kHz is not slowed if each report's change fits into eight ticks' bound.
TEST(BoardTest, AWishThatRampsAsALawsDoesIsReachedBeforeTheNextReport) {
  for (const Device& device : kDevices) {
    Rig rig = FullRig(device);
    const dvec3 here = rig.Reading();
    const double step_n = 0.9 * kTicksPerMs * MostChange_n(device, dvec3(0), kTick_s);
    double wish_n = 0;
    for (uint32_t ms = 0; wish_n + step_n < 0.45 * device.peak_n; ++ms) {
      wish_n += step_n;
      const EnCommand c = Wish(here - dvec3(wish_n / device.kc_n_per_m, 0, 0));
      ASSERT_TRUE(EnBoardObey(&rig.board, &c, 10'000 + ms));
      dvec3 force(0);
      for (int k = 0; k < kTicksPerMs; ++k) force = rig.Tick(rig.x);
      EXPECT_NEAR(force.x, -wish_n, 1e-9 * device.peak_n) << device.name;
    }
    EXPECT_GT(wish_n, 0) << device.name;
  }
}

TEST(BoardTest, AReadingThatIsNoNumberSwitchesOff) {
  Rig rig(kDevices[0], 0);
  EnCommand c = Wish(dvec3(1e-4, 0, 0));
  ASSERT_TRUE(EnBoardObey(&rig.board, &c, 1));
  rig.Tick(rig.x);
  for (double bad : {std::nan(""), 1e300}) {
    EXPECT_EQ(Of(EnBoardTick(&rig.board, {bad, 0, 0})), dvec3(0));
    EXPECT_FALSE(EnBoardDrives(&rig.board));
  }
  rig.Tick(rig.x);
  EXPECT_EQ(Of(rig.board.felt_n), dvec3(0));
}

}  // namespace
}  // namespace enamel
