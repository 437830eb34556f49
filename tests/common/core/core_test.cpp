#include "common/core/core.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/analytic_volume.h"

namespace enamel::core {
namespace {

CoreParams Params() {
  CoreParams p;
  p.kc_mn_per_mm = 2500;
  p.resolution_nm = {10'000, 10'000, 10'000};
  p.peak_force_mn = 7900;
  p.bur_shape = cutting::BurShape::kCylinder;
  p.bur_radius_nm = 600'000;
  p.bur_length_nm = 4'000'000;
  p.damping_mn_s_per_mm[1] = 6500;
  return p;
}

TickInput At(double x_m, double y_m, double z_m, uint8_t flags = kBurOn) {
  TickInput in;
  in.counts = {static_cast<int32_t>(std::lround(x_m / 10e-6)), static_cast<int32_t>(std::lround(y_m / 10e-6)),
               static_cast<int32_t>(std::lround(z_m / 10e-6))};
  in.flags = flags;
  return in;
}

// A hand that waits, comes down into the block and then moves sideways through it.
TickInput Stroke(int tick) {
  double down = std::min(std::max(0, tick - 600) * 1e-6, 1e-3), along = std::max(0.0, (tick - 1600) * 0.5e-6);
  return At(along, 0.2e-3 * std::sin(tick * 0.003), 0.2e-3 - down);
}

TEST(CoreTest, SameInputsGiveTheSameToothForcesAndHash) {
  Core a(Params(), test::Block(50'000, 3e-3, 3e-3)), b(Params(), test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 6000; ++tick) {
    TickOutput x = a.Step(Stroke(tick)), y = b.Step(Stroke(tick));
    ASSERT_EQ(x.witness, y.witness);
  }
  EXPECT_EQ(a.state_hash(), b.state_hash());
  EXPECT_TRUE(a.volume() == b.volume());
  EXPECT_GT(a.removed()[1], 0);
}

TEST(CoreTest, OneCountOfDifferenceInOneTickChangesTheHash) {
  Core a(Params(), test::Block(50'000, 3e-3, 3e-3)), b(Params(), test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 3000; ++tick) {
    TickInput in = Stroke(tick);
    a.Step(in);
    if (tick == 1500) in.counts[1] += 1;
    b.Step(in);
  }
  EXPECT_NE(a.state_hash(), b.state_hash());
}

TEST(CoreTest, SteadyCutFeelsTheTissuesDampingTimesTheFeed) {
  CoreParams p = Params();
  p.soft_start_ticks = 0;
  Core core(p, test::Block(50'000, 6e-3, 5e-3));  // its side is at x = -6 mm
  // Comes in from the block's side at its full length, then feeds at 0.4 mm/s for 12 s.
  core.Step(At(-6.8e-3, 0, -4e-3));
  TickOutput out;
  double sum = 0;
  for (int tick = 0; tick < 14000; ++tick) {
    out = core.Step(At(-6.8e-3 + tick * 0.4e-6, 0, -4e-3));
    if (tick >= 13000) sum -= out.force_sent_n.x;
  }
  EXPECT_NEAR(sum / 1000, 6.5 * 0.4, 0.12);
}

TEST(CoreTest, StillBurIsAWallThatDoesNotCutAndLetsTheHandWithdraw) {
  CoreParams p = Params();
  p.soft_start_ticks = 0;
  Core core(p, test::Block(50'000, 3e-3, 3e-3));
  TickOutput out;
  core.Step(At(0, 0, 0.1e-3, 0));
  for (int tick = 0; tick < 1000; ++tick) out = core.Step(At(0, 0, 0.1e-3 - tick * 1e-6, 0));
  EXPECT_EQ(core.removed(), cutting::RemovedUnits{});
  // Tip 0.9 mm under the surface: Kc * 0.9 mm, within half a voxel of where contact begins.
  EXPECT_NEAR(out.force_sent_n.z, 2.5 * 0.9, 2500 * 60e-6);
  for (int tick = 0; tick < 400; ++tick) out = core.Step(At(0, 0, -0.9e-3 + tick * 5e-6, 0));
  EXPECT_EQ(out.force_sent_n, dvec3(0));
}

TEST(CoreTest, StillBurSlidesAlongTheWall) {
  CoreParams p = Params();
  p.soft_start_ticks = 0;
  Core core(p, test::Block(50'000, 4e-3, 3e-3));
  TickOutput out;
  core.Step(At(0, 0, 0.1e-3, 0));
  for (int tick = 0; tick < 300; ++tick) out = core.Step(At(0, 0, 0.1e-3 - tick * 1e-6, 0));
  for (int tick = 0; tick < 1000; ++tick) out = core.Step(At(tick * 1e-6, 0, -0.2e-3, 0));
  EXPECT_NEAR(out.anchor.tip_m.x, 1e-3, 30e-6);
  EXPECT_LT(std::fabs(out.force_sent_n.x), 0.1);
}

TEST(CoreTest, ShortGapGoesOnWithTheCutWithoutAForceInTheTickAfterIt) {
  Core core(Params(), test::Block(50'000, 3e-3, 3e-3));
  TickOutput before, after;
  for (int tick = 0; tick < 2500; ++tick) before = core.Step(Stroke(tick));
  ASSERT_GT(glm::length(before.force_sent_n), 0.2);
  TickInput in = Stroke(2510);
  in.gap_ticks = 10;
  EXPECT_EQ(core.Step(in).force_sent_n, dvec3(0));
  for (int tick = 2511; tick < 2600; ++tick) after = core.Step(Stroke(tick));
  EXPECT_EQ(after.flags & kSuspended, 0);
  EXPECT_NEAR(glm::length(after.force_sent_n), glm::length(before.force_sent_n), 0.3);
}

// While nothing was known of the hand it went 1 mm deeper. The bur must not follow at no force.
TEST(CoreTest, LongGapInTheToothCutsNothingUntilTheBurHasBeenInFreeAir) {
  Core core(Params(), test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 2500; ++tick) core.Step(Stroke(tick));
  TickInput deep = At(0.25e-3, 0, -1.8e-3);
  deep.gap_ticks = 100;
  // What the bur had passed before the gap may still be booked, half a voxel of its front at most.
  int64_t lagging = core.removed()[1];
  TickOutput out = core.Step(deep);
  EXPECT_TRUE(out.flags & kAnchorReset);
  cutting::RemovedUnits before = core.removed();
  EXPECT_LT(cutting::RemovedUnitsToM3(before[1] - lagging, 50e-6), 25e-6 * (1.2e-3 * 1e-3 + 1.2e-6));
  deep.gap_ticks = 0;
  for (int tick = 0; tick < 1000; ++tick) {
    out = core.Step(deep);
    ASSERT_EQ(out.force_sent_n, dvec3(0));
    ASSERT_TRUE(out.flags & kSuspended);
  }
  EXPECT_EQ(core.removed(), before);
  for (int tick = 0; tick < 600; ++tick) out = core.Step(At(0, 0, 0.5e-3));
  EXPECT_EQ(out.flags & kSuspended, 0);
  for (int tick = 0; tick < 1000; ++tick) out = core.Step(At(1.5e-3, 0, 0.5e-3 - tick * 1e-6));
  EXPECT_NE(core.removed(), before);
}

TEST(CoreTest, StartInsideTheToothCutsNothing) {
  Core core(Params(), test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 2000; ++tick) {
    ASSERT_EQ(core.Step(At(0, 0, -1e-3 - tick * 0.2e-6)).force_sent_n, dvec3(0));
  }
  EXPECT_EQ(core.removed(), cutting::RemovedUnits{});
}

TEST(CoreTest, FaultHoldsZeroForceAndCutsNothingUntilCleared) {
  Core core(Params(), test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 2500; ++tick) core.Step(Stroke(tick));
  cutting::RemovedUnits before;
  for (int tick = 2500; tick < 2700; ++tick) {
    TickInput in = Stroke(tick);
    in.flags |= kFaulted;
    EXPECT_EQ(core.Step(in).force_sent_n, dvec3(0));
    if (tick == 2500) before = core.removed();  // with what the bur had passed before
  }
  EXPECT_EQ(core.removed(), before);
}

// A bur seated 2 mm deep is tilted by half a radian in half a second. Turned freely it would sweep some
// 3 mm^3; against the tissue it lags with B_rot / K_rot, which is B/Kc seconds here.
TEST(CoreTest, TurningTheBurInTheToothIsResisted) {
  CoreParams p = Params();
  p.rotational_kc_un_m_per_rad = 10'000;
  auto tilted = [](int tick) {
    double angle = tick * 1e-3;
    return ToQuantised(Quat{std::sin(angle / 2), 0, 0, std::cos(angle / 2)});
  };
  auto removed_by_turning = [&](const CoreParams& params) {
    Core core(params, test::Block(50'000, 4e-3, 4e-3));
    for (int tick = 0; tick < 600; ++tick) core.Step(At(0, 0, 0.5e-3));
    for (int tick = 0; tick < 9000; ++tick) core.Step(At(0, 0, std::max(-2e-3, 0.5e-3 - tick * 0.5e-6)));
    int64_t before = core.removed()[1];
    TickOutput out;
    for (int tick = 0; tick < 500; ++tick) {
      TickInput in = At(0, 0, -2e-3);
      in.orientation = tilted(tick);
      out = core.Step(in);
    }
    double turned = 2 * std::fabs(out.anchor.orientation.x);
    EXPECT_LT(turned, 0.25);
    return cutting::RemovedUnitsToM3(core.removed()[1] - before, 50e-6) * 1e9;
  };
  EXPECT_LT(removed_by_turning(p), 0.8);
  p.rotational_kc_un_m_per_rad = 0;
  EXPECT_LT(removed_by_turning(p), 1e-3) << "not followed at all";
}

TEST(CoreTest, InAirTheBurTurnsWithTheDevice) {
  CoreParams p = Params();
  p.rotational_kc_un_m_per_rad = 10'000;
  Core core(p, test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 600; ++tick) core.Step(At(0, 0, 6e-3));
  TickInput in = At(0, 0, 6e-3);
  in.orientation = ToQuantised(Quat{0.3, 0, 0, 0.9});
  TickOutput out;
  for (int tick = 0; tick < 3; ++tick) out = core.Step(in);
  EXPECT_NEAR(out.anchor.orientation.x, FromQuantised(in.orientation).x, 1e-3);
}

TEST(CoreTest, WildInputsStayBoundedInForceAndWork) {
  Core core(Params(), test::Block(100'000, 2e-3, 2e-3));
  std::mt19937_64 random(3);
  for (int tick = 0; tick < 300; ++tick) {
    TickInput in;
    for (auto& c : in.counts) {
      c = tick % 3 == 0 ? static_cast<int32_t>(random()) : static_cast<int32_t>(random() % 400) - 200;
    }
    for (auto& q : in.orientation) q = static_cast<int16_t>(random());
    in.flags = static_cast<uint8_t>(random());
    in.gap_ticks = random() % 10 == 0 ? static_cast<uint32_t>(random()) : 0;
    TickOutput out = core.Step(in);
    EXPECT_LE(glm::length(out.force_sent_n), 7.9 + 1e-9);
  }
}

TEST(CoreParamsTest, ComeBackFromTheirCanonicalBytes) {
  ByteWriter out;
  WriteParams(Params(), out);
  ByteReader in(out.bytes());
  auto back = ReadParams(in);
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_EQ(*back, Params());
}

TEST(CoreParamsTest, EveryTruncationIsRefused) {
  ByteWriter out;
  WriteParams(Params(), out);
  for (size_t n = 0; n < out.size(); ++n) {
    ByteReader in(ByteView(out.bytes()).first(n));
    EXPECT_FALSE(ReadParams(in).ok()) << n;
  }
}

TEST(CoreParamsTest, ForeignCoreVersionIsNamed) {
  CoreParams p = Params();
  p.core_version = 99;
  Status status = ValidateParams(p);
  EXPECT_EQ(status.code(), Code::kVersion);
  EXPECT_NE(status.message().find("99"), std::string::npos);
}

}  // namespace
}  // namespace enamel::core
