#include "common/core/core.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <random>
#include <utility>
#include <vector>

#include "tests/common/core/params.h"
#include "tests/support/analytic_volume.h"

namespace enamel::core {
namespace {

using test::At;
using test::Stroke;

CoreParams Params() { return test::ParamsFor({cutting::BurShape::kCylinder, 0.6e-3, 4e-3}); }

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

// Ticks that could not be recorded were not stepped either: what was recorded replays to the same
// bits, whichever ticks are missing.
TEST(CoreTest, UnrecordedTicksAtRandomPlacesDoNotBreakReplay) {
  std::mt19937_64 random(23);
  CoreParams params = Params();
  params.soft_start_ticks = 50;
  for (int attempt = 0; attempt < 4; ++attempt) {
    Core station(params, test::Block(50'000, 3e-3, 3e-3));
    std::vector<TickInput> recorded;
    int lost = 0;
    uint32_t gap = 0;
    for (int tick = 0; tick < 5000; ++tick) {
      if (lost == 0 && random() % 200 == 0) lost = 1 + static_cast<int>(random() % 5);
      if (lost > 0) {
        --lost;
        ++gap;
        continue;
      }
      TickInput in = Stroke(tick);
      in.gap_ticks = gap;
      gap = 0;
      station.Step(in);
      recorded.push_back(in);
    }
    Core server(params, test::Block(50'000, 3e-3, 3e-3));
    for (const TickInput& in : recorded) server.Step(in);
    EXPECT_EQ(server.state_hash(), station.state_hash());
    EXPECT_TRUE(server.volume() == station.volume());
    EXPECT_GT(station.removed()[1], 0);
  }
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

// What the hand does after the gap is paid only if it is felt at once.
TEST(CoreTest, ShortGapGoesOnWithTheCutAndWithLessForce) {
  Core core(Params(), test::Block(50'000, 3e-3, 3e-3));
  TickOutput before, after;
  for (int tick = 0; tick < 2500; ++tick) before = core.Step(Stroke(tick));
  ASSERT_GT(glm::length(before.force_sent_n), 0.2);
  TickInput in = Stroke(2510);
  in.gap_ticks = 10;
  const double resumed_n = glm::length(core.Step(in).force_sent_n);
  EXPECT_GT(resumed_n, 0.1 * glm::length(before.force_sent_n));
  EXPECT_LT(resumed_n, glm::length(before.force_sent_n));
  for (int tick = 2511; tick < 2600; ++tick) after = core.Step(Stroke(tick));
  EXPECT_EQ(after.flags & kSuspended, 0);
  EXPECT_NEAR(glm::length(after.force_sent_n), glm::length(before.force_sent_n), 0.3);
}

// A late tick skips time and nothing else: the same forces, anchors and cut as without.
TEST(CoreTest, HeldGapIsOnlyTime) {
  Core whole(Params(), test::Block(50'000, 3e-3, 3e-3));
  Core late(Params(), test::Block(50'000, 3e-3, 3e-3));
  double most_n = 0;
  for (int tick = 0; tick < 2500; ++tick) {
    TickInput in = Stroke(tick);
    TickWitness expected = whole.Step(in).witness;
    if (tick % 9 == 8) {
      in.gap_ticks = 1 + static_cast<uint32_t>(tick % 4);
      in.flags |= kLateTick | kHeldGap;
    }
    TickOutput out = late.Step(in);
    ASSERT_EQ(out.witness, expected) << tick;
    most_n = std::max(most_n, glm::length(out.force_sent_n));
  }
  EXPECT_GT(most_n, 0.2);
  EXPECT_EQ(late.removed(), whole.removed());
  EXPECT_NE(late.state_hash(), whole.state_hash());  // the time is part of what is agreed on
}

// While nothing was known of the hand it went 1 mm deeper. The bur must not follow at no force.
TEST(CoreTest, LongGapInTheToothCutsNothingUntilTheBurHasBeenInFreeAir) {
  Core core(Params(), test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 2500; ++tick) core.Step(Stroke(tick));
  TickInput deep = At(0.25e-3, 0, -1.8e-3);
  deep.gap_ticks = 100;
  // Removal from before the gap may still be booked: half a voxel of the bur's front at most.
  int64_t lagging = core.removed()[1];
  TickOutput out = core.Step(deep);
  EXPECT_TRUE(out.flags & kAnchorReset);
  cutting::RemovedUnits before = core.removed();
  EXPECT_LT(cutting::RemovedUnitsToM3(before[1] - lagging, 50e-6),
            25e-6 * (1.2e-3 * 1e-3 + 1.2e-6));
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

// A bur seated 2 mm deep is tilted by half a radian in half a second. Turned freely it would sweep
// some 3 mm^3; against the tissue it lags with B_rot / K_rot, which is B/Kc seconds here.
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
    for (int tick = 0; tick < 9000; ++tick)
      core.Step(At(0, 0, std::max(-2e-3, 0.5e-3 - tick * 0.5e-6)));
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
  // 2 um of the bur's way down are left after 4 s.
  EXPECT_LT(removed_by_turning(p), 2e-3) << "not followed at all";
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

// A hand that comes down fast and then feeds sideways once held nothing: the axis it had come down
// along had stopped counting, and was taken for a hand that had stopped. Plain Maxwell has no
// estimator that could be wrong about it.
TEST(CoreTest, AFeedAfterAPlungeIsResistedAsPlainMaxwellResistsIt) {
  struct Hand {
    double plunge_m_per_s, feed_m_per_s;
  };
  for (const Hand& hand :
       {Hand{1e-3, 0.5e-3}, Hand{5e-3, 0.2e-3}, Hand{10e-3, 0.5e-3}, Hand{20e-3, 1e-3}}) {
    auto force_n = [&](haptics::LawKind law) {
      CoreParams p = test::ParamsFor({cutting::BurShape::kCylinder, 0.6e-3, 4e-3});
      p.law = law;
      Core core(p, test::Block(50'000, 3e-3, 3e-3));
      const double down_s = 0.7e-3 / hand.plunge_m_per_s;
      double sum_n = 0;
      constexpr int kFirst = 2500, kEnd = 3000;
      for (int tick = 0; tick < kEnd; ++tick) {
        const double t = std::max(0, tick - 600) * 1e-3;
        TickOutput out = core.Step(At(std::max(0.0, t - down_s - 0.1) * hand.feed_m_per_s, 0,
                                      0.2e-3 - std::min(t * hand.plunge_m_per_s, 0.7e-3)));
        if (tick >= kFirst) sum_n -= out.force_sent_n.x;
      }
      return sum_n / (kEnd - kFirst);
    };
    const double maxwell_n = force_n(haptics::LawKind::kMaxwell);
    ASSERT_GT(maxwell_n, 0.1);
    EXPECT_NEAR(force_n(haptics::LawKind::kLeadMaxwell), maxwell_n, 0.25 * maxwell_n)
        << hand.plunge_m_per_s << " m/s down, " << hand.feed_m_per_s << " m/s along";
  }
}

TickInput AtCells(const CoreParams& p, double x_m, double y_m, double z_m) {
  TickInput in = At(0, 0, 0);
  const double at_m[] = {x_m, y_m, z_m};
  for (size_t i = 0; i < 3; ++i)
    in.counts[i] = static_cast<int32_t>(std::lround(at_m[i] * 1e9 / p.resolution_nm[i]));
  return in;
}

// A bur that stayed behind a hand that has stopped would leave solid tissue between the force and the
// picture, and meet the next feed there.
TEST(CoreTest, TheBurComesUpToAHandThatHasStoppedSoonerThanThePlainSpringsDoes) {
  struct Left {
    double force_n, behind_m;
  };
  auto After = [](haptics::LawKind law, int32_t kc) {
    CoreParams p = test::ParamsFor({cutting::BurShape::kCylinder, 0.6e-3, 4e-3});
    p.law = law;
    p.kc_mn_per_mm = kc;
    p.resolution_nm.fill(kc == 1000 ? 30'000 : 20'000);
    Core core(p, test::Block(50'000, 3e-3, 3e-3));
    TickOutput out;
    TickInput in;
    for (int tick = 0; tick < 3000; ++tick) {
      in = AtCells(p, 0, 0, 0.2e-3 - std::min(std::max(0, tick - 600) * 10e-6, 1.2e-3));
      out = core.Step(in);
    }
    return Left{glm::length(out.force_sent_n),
                glm::length(core.TipOf(in.counts) - out.anchor.tip_m)};
  };
  for (int32_t kc : {1000, 2000, 2500}) {
    const Left lead = After(haptics::LawKind::kLeadMaxwell, kc);
    const Left plain = After(haptics::LawKind::kMaxwell, kc);
    EXPECT_LT(lead.force_n, 0.75 * plain.force_n) << kc;
    EXPECT_LT(lead.behind_m, 0.6 * plain.behind_m) << kc;
  }
}

// The force is 0 where the tip meets the bur, which is no farther than R/Kc behind it.
TEST(CoreTest, OnAFineEncoderAHandThatGoesBackInItsSlotIsLetGo) {
  for (double back_m_per_s : {0.1e-3, 0.2e-3, 0.5e-3}) {
    CoreParams p = test::ParamsFor({cutting::BurShape::kCylinder, 0.6e-3, 4e-3});
    p.law = haptics::LawKind::kLeadMaxwell;
    p.resolution_nm.fill(100);
    Core core(p, test::Block(50'000, 3e-3, 3e-3));
    constexpr int kTurn = 3000, kEnd = 5000;
    int helped = 0;
    double cut_n = 0;
    for (int tick = 0; tick < kEnd; ++tick) {
      const double in_m = std::max(0, std::min(tick, kTurn) - 900) * 0.8e-6;
      const double back_m = std::max(0, tick - kTurn) * back_m_per_s * 1e-3;
      const double down_m = std::min(std::max(0, tick - 600) * 5e-6, 1.2e-3);
      TickOutput out = core.Step(AtCells(p, in_m - back_m, 0, 0.2e-3 - down_m));
      if (tick == kTurn - 1) cut_n = -out.force_sent_n.x;
      if (tick >= kTurn && out.force_sent_n.x < -0.1) ++helped;
    }
    ASSERT_GT(cut_n, 0.5);
    const double longest_s = cut_n / (p.kc_mn_per_mm * back_m_per_s);
    EXPECT_LT(helped, 1e3 * longest_s) << back_m_per_s << " m/s back";
  }
}

TEST(CoreTest, WildInputsStayBoundedInForceAndWork) {
  CoreParams p = Params();
  p.chatter_cue_mn = p.contact_cue_mn = 2000;
  p.cue_energy_nj = 1'000'000;
  Core core(p, test::Block(100'000, 2e-3, 2e-3));
  std::mt19937_64 random(3);
  for (int tick = 0; tick < 300; ++tick) {
    TickInput in;
    for (auto& c : in.counts) {
      c = tick % 3 == 0 ? static_cast<int32_t>(random())
                        : static_cast<int32_t>(random() % 400) - 200;
    }
    for (auto& q : in.orientation) q = static_cast<int16_t>(random());
    in.flags = static_cast<uint8_t>(random());
    in.gap_ticks = random() % 10 == 0 ? static_cast<uint32_t>(random()) : 0;
    TickOutput out = core.Step(in);
    EXPECT_LE(glm::length(out.force_sent_n), 7.9 + 1e-9);
  }
}

CoreParams CueParams() {
  CoreParams p = Params();
  p.contact_cue_mn = 300;
  p.chatter_cue_mn = 200;
  p.cue_energy_nj = 200'000;
  p.cue_power_nw = 1'000'000;
  return p;
}

// A hand that comes down at 10 mm/s, cuts sideways and lifts off again.
TickInput Tap(int tick) {
  double down = std::min(std::max(0, tick - 600) * 10e-6, 0.7e-3);
  if (tick >= 3000) down = std::max(0.0, 0.7e-3 - (tick - 3000) * 10e-6);
  TickInput in = test::At(std::max(0.0, (std::min(tick, 3000) - 800) * 0.5e-6), 0, 0.2e-3 - down);
  in.bur_speed_krpm = 300;
  return in;
}

TEST(CoreTest, TouchCuesChangeNothingButTheForceSentAndAreSilentInAir) {
  for (haptics::LawKind law : {haptics::LawKind::kMaxwell, haptics::LawKind::kLeadMaxwell}) {
    CoreParams on = CueParams(), off = Params();
    on.law = off.law = law;
    on.handpiece_stall_un_m = off.handpiece_stall_un_m = 2330;
    on.handpiece_tangential_permille = off.handpiece_tangential_permille = 300;
    Core cued(on, test::Block(50'000, 3e-3, 3e-3)), plain(off, test::Block(50'000, 3e-3, 3e-3));
    int knocking = 0, chattering = 0;
    for (int tick = 0; tick < 3500; ++tick) {
      TickOutput a = cued.Step(Tap(tick)), b = plain.Step(Tap(tick));
      ASSERT_EQ(a.force_computed_n, b.force_computed_n) << tick;
      ASSERT_EQ(a.anchor.tip_m, b.anchor.tip_m) << tick;
      ASSERT_EQ(a.bur_speed_ratio, b.bur_speed_ratio) << tick;
      ASSERT_EQ(a.removed, b.removed) << tick;
      ASSERT_EQ(a.pressed_n(), b.pressed_n()) << tick;
      ASSERT_EQ(PressedForce_mn(a.witness), PressedForce_mn(b.witness)) << tick;
      ASSERT_EQ(a.flags, b.flags) << tick;
      ASSERT_EQ(a.force_sent_n, b.force_sent_n + a.cue_n) << tick;
      const double cue = glm::length(a.cue_n);
      EXPECT_LE(cue, 0.5);
      if (cue > 0.01) (tick < 800 ? knocking : chattering) += 1;
      if (tick < 600 || tick > 3200) {
        ASSERT_EQ(cue, 0) << tick;
      }
    }
    EXPECT_TRUE(cued.volume() == plain.volume());
    EXPECT_NE(cued.state_hash(), plain.state_hash());
    EXPECT_GT(knocking, 5);
    EXPECT_GT(chattering, 50);
  }
}

// What is recorded of a hand must not depend on how much of its work the device's friction does.
TEST(CoreTest, OneMotionPressesAlikeOnDevicesWithFrictionAndWithout) {
  CoreParams with = Params(), without = Params();
  with.handpiece_stall_un_m = without.handpiece_stall_un_m = 2330;
  with.handpiece_tangential_permille = without.handpiece_tangential_permille = 300;
  with.friction_mn = {90, 60, 120};
  // Soft tissue, in which half of a guess is left out.
  with.damping_mn_s_per_mm.fill(100);
  without.damping_mn_s_per_mm.fill(100);
  Core rough(with, test::Block(50'000, 3e-3, 3e-3)),
      smooth(without, test::Block(50'000, 3e-3, 3e-3));
  int left_to_friction = 0;
  for (int tick = 0; tick < 3500; ++tick) {
    const TickOutput a = rough.Step(Tap(tick)), b = smooth.Step(Tap(tick));
    ASSERT_LT(glm::length(a.anchor.tip_m - b.anchor.tip_m), 1e-12) << tick;
    ASSERT_EQ(a.removed, b.removed) << tick;
    ASSERT_NEAR(a.bur_speed_ratio, b.bur_speed_ratio, 1e-9) << tick;
    for (size_t i = 0; i < 3; ++i) {
      ASSERT_NEAR(PressedForce_mn(a.witness)[i], PressedForce_mn(b.witness)[i], 1) << tick;
    }
    left_to_friction += glm::length(b.force_sent_n - a.force_sent_n) > 0.02;
  }
  EXPECT_GT(left_to_friction, 190);
}

TEST(CoreTest, TouchCuesWithoutForceOrEnergyAreNone) {
  CoreParams no_force = Params(), no_energy = CueParams();
  no_force.cue_energy_nj = 1'000;
  no_force.cue_power_nw = 1'000;
  no_energy.cue_energy_nj = 0;
  Core plain(Params(), test::Block(50'000, 3e-3, 3e-3));
  Core a(no_force, test::Block(50'000, 3e-3, 3e-3)), b(no_energy, test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 2000; ++tick) {
    TickWitness expected = plain.Step(Tap(tick)).witness;
    ASSERT_EQ(a.Step(Tap(tick)).witness, expected);
    ASSERT_EQ(b.Step(Tap(tick)).witness, expected);
  }
  EXPECT_EQ(a.state_hash(), plain.state_hash());
  EXPECT_EQ(b.state_hash(), plain.state_hash());
}

// A hand that goes along with every cue, while it cuts: what it draws from them is bounded.
TEST(CoreTest, WhatAHandDrawsFromTouchCuesIsBounded) {
  for (uint32_t delay : {0u, 1u, 2u}) {
    CoreParams p = CueParams();
    p.bus_delay_ticks = delay;
    p.cue_power_nw = 0;
    Core core(p, test::Block(50'000, 3e-3, 3e-3));
    dvec3 x(0, 0, 0.2e-3), v(0), felt[3] = {};
    double drawn = 0, most = 0;
    for (int tick = 0; tick < 8000; ++tick) {
      TickInput in = test::At(x.x, x.y, x.z);
      in.bur_speed_krpm = 300;
      TickOutput out = core.Step(in);
      for (int d = 2; d > 0; --d) felt[d] = felt[d - 1];
      felt[0] = out.cue_n;
      const bool down = tick >= 600 && x.z > -0.5e-3;
      dvec3 goal(tick < 1000 ? 0 : 0.5e-3, 0, down ? -5e-3 : 0);
      for (int i = 0; i < 3; ++i) {
        if (felt[delay][i] != 0) goal[i] += std::copysign(0.05, felt[delay][i]);
        v[i] += std::clamp(goal[i] - v[i], -0.1, 0.1);
      }
      drawn += Dot(felt[delay], v) * 1e-3;
      x += v * 1e-3;
      most = std::max(most, drawn);
    }
    EXPECT_LE(most, 200e-6);
    EXPECT_GT(most, 20e-6) << "the hand is no attack";
  }
}

// The bur's side feels the shank's wall long before the ball does: it stops there and cuts nothing,
// is felt as a wall, and slides and withdraws freely.
TEST(CoreTest, ShankIsAWallThatDoesNotCut) {
  CoreParams p = test::ParamsFor({cutting::BurShape::kSphere, 0.3e-3, 0, 0, 0.8e-3, 0.5e-3});
  p.soft_start_ticks = 0;
  p.resolution_nm = {1'000, 1'000, 1'000};
  Core core(p, test::Block(50'000, 2e-3, 6e-3));  // its side is at x = 2 mm
  auto at = [](double x, double y) {
    TickInput in;
    in.counts = {static_cast<int32_t>(std::lround(x * 1e6)),
                 static_cast<int32_t>(std::lround(y * 1e6)), -4000};
    in.flags = kBurOn;
    return in;
  };
  TickOutput out;
  core.Step(at(2.9e-3, 0));
  for (int tick = 0; tick < 500; ++tick) out = core.Step(at(2.9e-3 - tick * 1e-6, 0));
  EXPECT_EQ(core.removed(), cutting::RemovedUnits{});
  EXPECT_NEAR(out.anchor.tip_m.x, 2.8e-3, 40e-6);
  EXPECT_NEAR(out.force_sent_n.x, 2500 * (out.anchor.tip_m.x - 2.401e-3), 1e-3);
  for (int tick = 0; tick < 500; ++tick) out = core.Step(at(2.401e-3, tick * 1e-6));
  EXPECT_NEAR(out.anchor.tip_m.y, 0.499e-3, 30e-6);
  for (int tick = 0; tick < 500; ++tick) out = core.Step(at(2.401e-3 + tick * 1e-6, 0.499e-3));
  EXPECT_LT(glm::length(out.force_sent_n), 0.01);
}

// Steady feed v against B: the bur settles where F (1 - r k F / tau) = B v.
TEST(CoreTest, HandpieceSlowsDownUnderLoadAndResistsMore) {
  auto force = [](int32_t stall_un_m, double* ratio) {
    CoreParams p = Params();
    p.soft_start_ticks = 0;
    p.handpiece_stall_un_m = stall_un_m;
    p.handpiece_tangential_permille = 400;
    p.handpiece_lag_us = 20'000;
    Core core(p, test::Block(50'000, 6e-3, 5e-3));
    core.Step(At(-6.8e-3, 0, -4e-3));
    double sum = 0;
    for (int tick = 0; tick < 22000; ++tick) {
      TickOutput out = core.Step(At(-6.8e-3 + tick * 0.3e-6, 0, -4e-3));
      if (tick >= 21000) sum -= out.force_sent_n.x;
      *ratio = out.bur_speed_ratio;
    }
    return sum / 1000;
  };
  double free_ratio = 0, loaded_ratio = 0;
  double ideal = force(0, &free_ratio), loaded = force(2330, &loaded_ratio);
  EXPECT_EQ(free_ratio, 1);
  EXPECT_NEAR(loaded_ratio, 1 - 0.6e-3 * 0.4 * loaded / 2.33e-3, 0.01);
  EXPECT_NEAR(loaded * loaded_ratio, ideal, 0.03 * ideal);
  EXPECT_GT(loaded, 1.2 * ideal);
}

// Tissue that is cut by load, 0.2 N + 2.6 N (v/0.43 mm/s)^(1/2) on the reference bur: a hand that goes at v feels that, the
// turning bur drags it across, and the spindle slows by the torque of the drag, which is 1.37 (the root's part) to
// 1.57 (Coulomb's) times mu r times the force along, by the integrals of cos^m over the front.
TEST(CoreTest, ALoadIsFeltDragsAcrossAndSlowsTheSpindle) {
  CoreParams p = Params();
  p.bur_shape = cutting::BurShape::kCylinder;
  p.bur_radius_nm = 600'000;
  p.bur_length_nm = 4'000'000;
  p.soft_start_ticks = 0;
  p.damping_mn_s_per_mm[1] = 6'047;
  p.coulomb_mn[1] = 200;
  p.feed_exponent[1] = cutting::FeedExponent::kHalf;
  p.feed_um_per_s[1] = 430;
  p.bur_friction_permille[1] = 500;
  p.handpiece_stall_un_m = 2330;
  p.handpiece_lag_us = 20'000;
  Core core(p, test::Block(50'000, 6e-3, 5e-3));
  core.Step(At(-6.8e-3, 0, -4e-3));
  constexpr double kSpeed = 0.3e-3;
  double along = 0, across = 0, ratio = 0;
  for (int tick = 0; tick < 16'000; ++tick) {
    const TickOutput out = core.Step(At(-6.8e-3 + tick * kSpeed * 1e-3, 0, -4e-3));
    if (tick < 15'000) continue;
    along -= out.force_sent_n.x / 1000;
    across += out.force_sent_n.y / 1000;
    ratio = out.bur_speed_ratio;
  }
  const double right = 0.2 + 2.6 * std::sqrt(kSpeed / ratio / 0.43e-3);
  EXPECT_NEAR(along, right, 0.05 * right);
  EXPECT_NEAR(across, 0.5 * along, 0.1 * along);
  const double slowed = (1 - ratio) * 2.33e-3 / (0.5 * 0.6e-3 * right);
  // The reader leaves out up to 5 % of it (engagement_test).
  EXPECT_GT(slowed, 0.95 * 1.37 - 0.01);
  EXPECT_LT(slowed, 1.57);
}

TEST(CoreTest, StalledHandpieceStillGivesWayAndRecovers) {
  CoreParams p = Params();
  p.soft_start_ticks = 0;
  p.handpiece_stall_un_m = 100;
  p.handpiece_tangential_permille = 1000;
  Core core(p, test::Block(50'000, 3e-3, 3e-3));
  TickOutput out;
  for (int tick = 0; tick < 3000; ++tick) out = core.Step(Stroke(tick));
  EXPECT_NEAR(out.bur_speed_ratio, Handpiece::kSlowest, 1e-6);
  EXPECT_TRUE(std::isfinite(glm::length(out.force_sent_n)));
  for (int tick = 0; tick < 3000; ++tick) out = core.Step(At(0, 0, 3e-3));
  EXPECT_NEAR(out.bur_speed_ratio, 1, 1e-6);
}

// A law without an anchor takes the bur to the tip: 10 mm in a tick is no cut but a fault.
TEST(CoreTest, StepLongerThanTheMaximumCutsNothingAndSuspends) {
  CoreParams p = Params();
  p.soft_start_ticks = 0;
  p.law = haptics::LawKind::kPaperDamping;
  Core core(p, test::Block(50'000, 6e-3, 3e-3));
  core.Step(At(-7e-3, 0, 0.5e-3));
  core.Step(At(-7e-3, 0, 0.5e-3));
  TickOutput out = core.Step(At(5e-3, 0, -1e-3));
  EXPECT_TRUE(out.flags & kStepTooLong);
  EXPECT_TRUE(out.flags & kSuspended);
  EXPECT_EQ(out.force_sent_n, dvec3(0));
  EXPECT_EQ(core.removed(), cutting::RemovedUnits{});
  out = core.Step(At(5e-3, 0, -1.001e-3));
  EXPECT_EQ(out.flags & kStepTooLong, 0);
  EXPECT_EQ(core.removed(), cutting::RemovedUnits{});
}

// The hole of one polyline of tip positions, cut at every pace. eq. 1 puts the bur where the tip
// is, so that the path is the same whatever the force.
struct Hole {
  int64_t removed;
  cutting::Volume volume;
};
Hole CutPolyline(double speed_m_s, uint32_t rate_hz) {
  CoreParams p = Params();
  p.soft_start_ticks = 0;
  p.law = haptics::LawKind::kPaperDamping;
  p.rate_hz = rate_hz;
  p.resolution_nm = {10, 10, 10};
  p.bur_radius_nm = 400'000;
  p.bur_length_nm = 1'500'000;
  Core core(p, test::Block(50'000, 1.2e-3, 1.2e-3));
  auto step = [&](const dvec3& at, uint8_t flags) {
    TickInput in;
    for (int i = 0; i < 3; ++i)
      in.counts[static_cast<size_t>(i)] = static_cast<int32_t>(std::lround(at[i] * 1e8));
    in.flags = flags;
    core.Step(in);
  };
  const dvec3 corners[] = {dvec3(-0.5e-3, -0.3e-3, 0.2e-3), dvec3(-0.5e-3, -0.3e-3, -0.4e-3),
                           dvec3(0.5e-3, -0.3e-3, -0.4e-3), dvec3(0.1e-3, 0.4e-3, -0.5e-3),
                           dvec3(0.1e-3, 0.4e-3, 0.3e-3)};
  step(corners[0], kBurOn);
  step(corners[0], kBurOn);
  for (size_t i = 0; i + 1 < std::size(corners); ++i) {
    dvec3 way = corners[i + 1] - corners[i];
    int ticks = std::max(1, static_cast<int>(std::ceil(glm::length(way) * rate_hz / speed_m_s)));
    for (int k = 1; k <= ticks; ++k)
      step(corners[i] + way * (static_cast<double>(k) / ticks), kBurOn);
  }
  step(corners[4], 0);
  return {core.removed()[1], core.volume()};
}

TEST(CoreTest, SamePolylineMakesTheSameHoleAtEverySpeedAndRate) {
  Hole reference = CutPolyline(1e-3, 1000);
  const double whole = cutting::RemovedUnitsToM3(reference.removed, 50e-6);
  EXPECT_GT(whole, 0.5e-9);
  struct Pace {
    double speed_m_s;
    uint32_t rate_hz;
  };
  for (Pace pace :
       {Pace{0.1e-3, 100}, Pace{0.1e-3, 10'000}, Pace{1e-3, 100}, Pace{5e-3, 1000},
        Pace{20e-3, 10'000}, Pace{100e-3, 100}, Pace{100e-3, 1000}, Pace{100e-3, 10'000}}) {
    Hole hole = CutPolyline(pace.speed_m_s, pace.rate_hz);
    double volume_error =
        static_cast<double>(hole.removed) / static_cast<double>(reference.removed) - 1;
    // Where the reference's surface is, how far the other's is from it.
    double worst = 0;
    const auto& spec = reference.volume.spec();
    ivec3 n = spec.voxels();
    for (int z = 0; z < n.z; ++z)
      for (int y = 0; y < n.y; ++y)
        for (int x = 0; x < n.x; ++x) {
          int a = reference.volume.PhiAt({x, y, z}), b = hole.volume.PhiAt({x, y, z});
          if (std::abs(a) < 4096) worst = std::max(worst, std::abs(a - b) / 8192.0);
        }
    std::printf("%6g mm/s at %5u Hz: volume %+.4f %%, surface at most %.4f voxel away\n",
                pace.speed_m_s * 1e3, pace.rate_hz, 100 * volume_error, worst);
    EXPECT_LT(std::fabs(volume_error), 1e-3);
    EXPECT_LT(worst, 1.0 / 16);
  }
}

// The first bur and, as bur 1, a ball that is wider.
CoreParams TwoBurs() {
  CoreParams params = Params();
  params.soft_start_ticks = 50;
  params.other_burs = {{cutting::BurShape::kSphere, 1'000'000}};
  return params;
}

TickInput With(TickInput input, size_t bur) {
  input.flags |= BurFlags(bur);
  return input;
}

TEST(BurChangeTest, AnotherBurThatIsNeverTakenChangesNothing) {
  CoreParams one = TwoBurs();
  one.other_burs.clear();
  Core alone(one, test::Block(50'000, 3e-3, 3e-3)),
      beside(TwoBurs(), test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 4000; ++tick) {
    ASSERT_EQ(alone.Step(Stroke(tick)).witness, beside.Step(Stroke(tick)).witness) << tick;
  }
  EXPECT_EQ(alone.state_hash(), beside.state_hash());
  EXPECT_GT(alone.removed()[1], 0);
}

// The second bur from tick 300 on, in air: from there to the end it is the core of an exercise that has it alone and
// restarts there.
TEST(BurChangeTest, ABurTakenInAirCutsLikeOneThatWasThereFromTheStart) {
  CoreParams ball = test::ParamsFor({cutting::BurShape::kSphere, 1e-3});
  ball.soft_start_ticks = 50;
  Core alone(ball, test::Block(50'000, 3e-3, 3e-3)),
      changed(TwoBurs(), test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 4000; ++tick) {
    TickInput restart = Stroke(tick);
    if (tick == 300) restart.flags |= kSoftRestart;
    const TickOutput expected = alone.Step(restart);
    const TickOutput found = changed.Step(With(Stroke(tick), tick < 300 ? 0 : 1));
    const bool suspended = tick <= 50 || (tick >= 300 && tick <= 350);
    ASSERT_EQ((found.flags & kSuspended) != 0, suspended) << tick;
    ASSERT_EQ(found.witness, expected.witness) << tick;
  }
  EXPECT_EQ(changed.bur(), 1u);
  EXPECT_TRUE(alone.volume() == changed.volume());
  EXPECT_EQ(alone.removed(), changed.removed());
}

// Stroke() is a millimetre deep in the block from tick 1600 on.
TEST(BurChangeTest, ABurTakenInTheToothNeitherCutsNorPushesUntilItIsOutOfIt) {
  Core core(TwoBurs(), test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 2500; ++tick) core.Step(Stroke(tick));
  // What the first bur had passed and not yet cut still goes.
  core.Step(With(Stroke(2500), 1));
  const cutting::RemovedUnits before = core.removed();
  for (int tick = 2501; tick < 3500; ++tick) {
    const TickOutput out = core.Step(With(Stroke(tick), 1));
    ASSERT_EQ(out.force_sent_n, dvec3(0)) << tick;
    ASSERT_NE(out.flags & kSuspended, 0) << tick;
  }
  EXPECT_EQ(core.removed(), before);
  for (int tick = 0; tick < 100; ++tick) core.Step(With(At(0, 0, 3e-3), 1));
  for (int tick = 0; tick < 2000; ++tick) core.Step(With(At(0, 0, (3 - 2e-3 * tick) * 1e-3), 1));
  EXPECT_GT(core.removed()[1], before[1]);
}

TEST(BurChangeTest, ANumberThatNoBurHasIsAFault) {
  Core core(TwoBurs(), test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 2500; ++tick) core.Step(Stroke(tick));
  core.Step(With(Stroke(2500), 7));
  const cutting::RemovedUnits before = core.removed();
  const TickOutput out = core.Step(With(Stroke(2501), 2));
  EXPECT_EQ(out.force_sent_n, dvec3(0));
  EXPECT_NE(out.flags & kSuspended, 0);
  EXPECT_EQ(core.removed(), before);
  EXPECT_EQ(core.bur(), 0u);
}

TEST(BurChangeTest, TheBurOfATickIsInTheHash) {
  Core a(TwoBurs(), test::Block(50'000, 3e-3, 3e-3)), b(TwoBurs(), test::Block(50'000, 3e-3, 3e-3));
  a.Step(Stroke(0));
  b.Step(With(Stroke(0), 1));
  EXPECT_NE(a.state_hash(), b.state_hash());
}

// Every field at a value of its own.
CoreParams FullParams() {
  CoreParams p = Params();
  p.bur_shape = cutting::BurShape::kCylinder;
  p.bur_length_nm = 4'000'000;
  p.shank_radius_nm = 800'000;
  p.neck_nm = 1'000'000;
  p.axial_damping_mn_s_per_mm[1] = 9000;
  p.handpiece_stall_un_m = 1500;
  p.handpiece_lag_us = 20'000;
  p.bus_delay_ticks = 16;
  p.coulomb_mn = {0, 300, 200, 100, 90, 80, 70, 60};
  p.feed_exponent[1] = cutting::FeedExponent::kHalf;
  p.feed_um_per_s = {0, 430, 420, 0, 0, 0, 0, 9};
  p.bur_friction_permille = {0, 500, 450, 100, 200, 700, 0, 500};
  p.peak_torque_un_m = 250'000;
  p.rotation_cell_urad = 400;
  p.rotational_kc_un_m_per_rad = 800'000;
  p.contact_cue_mn = 300;
  p.chatter_cue_mn = 200;
  p.cue_energy_nj = 50'000;
  p.cue_power_nw = 100'000;
  p.friction_mn = {90, 25, 80};
  p.friction_measured = true;
  p.other_burs = {
      {cutting::BurShape::kPear, 600'000, 2'500'000, 350'000, 800'000, 1'000'000, 800'000},
      {cutting::BurShape::kSphere, 800'000, 0, 0, 0, 0, 800'000}};
  return p;
}

TEST(CoreParamsTest, ComeBackFromTheirCanonicalBytes) {
  for (const CoreParams& params : {Params(), FullParams()}) {
    ByteWriter out;
    WriteParams(params, out);
    EXPECT_EQ(out.size(), kMinParamsBytes + params.other_burs.size() * kOtherBurBytes);
    ByteReader in(out.bytes());
    auto back = ReadParams(in);
    ASSERT_TRUE(back.ok()) << back.status().message();
    EXPECT_EQ(*back, params);
    EXPECT_TRUE(ValidateParams(*back).ok()) << ValidateParams(*back).message();
  }
}

TEST(CoreParamsTest, ValuesOutOfRangeAreRefusedByName) {
  auto refused = [](auto set) {
    CoreParams p = FullParams();
    set(p);
    return ValidateParams(p).field();
  };
  EXPECT_EQ(refused([](CoreParams& p) { p.bus_delay_ticks = 17; }), "bus_delay_ticks");
  EXPECT_EQ(refused([](CoreParams& p) { p.coulomb_mn[7] = -1; }), "coulomb_mn");
  EXPECT_EQ(refused([](CoreParams& p) { p.feed_um_per_s[1] = 0; }), "feed_um_per_s");
  EXPECT_EQ(refused([](CoreParams& p) { p.bur_friction_permille[3] = -1; }),
            "bur_friction_permille");
  EXPECT_EQ(refused([](CoreParams& p) { p.feed_exponent[2] = cutting::FeedExponent{3}; }),
            "feed_exponent");
  // The spindle's load would be counted twice.
  EXPECT_EQ(refused([](CoreParams& p) { p.handpiece_tangential_permille = 500; }),
            "handpiece_tangential_permille");
  EXPECT_EQ(refused([](CoreParams& p) { p.peak_torque_un_m = -1; }), "peak_torque_un_m");
  // A torque needs a spring, and to know how well the orientation is known: no better than it is
  // recorded. And a bound that lets the bur follow the hand in air.
  EXPECT_EQ(refused([](CoreParams& p) { p.rotation_cell_urad = 61; }), "rotation_cell_urad");
  EXPECT_EQ(refused([](CoreParams& p) { p.rotational_kc_un_m_per_rad = 0; }),
            "rotational_kc_un_m_per_rad");
  EXPECT_EQ(refused([](CoreParams& p) { p.peak_torque_un_m = 639; }), "peak_torque_un_m");
  EXPECT_EQ(refused([](CoreParams& p) { p.peak_torque_un_m = 640; }), "");
  EXPECT_EQ(refused([](CoreParams& p) { p.contact_cue_mn = 2001; }), "contact_cue_mn");
  EXPECT_EQ(refused([](CoreParams& p) { p.chatter_cue_mn = -1; }), "chatter_cue_mn");
  EXPECT_EQ(refused([](CoreParams& p) { p.cue_energy_nj = 1'000'001; }), "cue_energy_nj");
  EXPECT_EQ(refused([](CoreParams& p) { p.cue_power_nw = -1; }), "cue_power_nw");
  EXPECT_EQ(refused([](CoreParams& p) { p.friction_mn[2] = -1; }), "friction_mn");
  EXPECT_EQ(refused([](CoreParams& p) { p.other_burs.resize(8, p.other_burs[0]); }), "other_burs");
  EXPECT_EQ(refused([](CoreParams& p) { p.other_burs[1].radius_nm = 1; }), "bur_radius_nm");
  // What a six-axis device lets the hand feel does not depend on the bur.
  EXPECT_EQ(refused([](CoreParams& p) { p.other_burs[1].rotational_kc_un_m_per_rad = 1; }),
            "rotational_kc_un_m_per_rad");
}

TEST(CoreParamsTest, ImpossibleBurIsRefusedWithItsMeasures) {
  CoreParams p = test::ParamsFor({cutting::BurShape::kPear, 0.5e-3, 0.8e-3, 0.3e-3});
  Status status = ValidateParams(p);
  EXPECT_EQ(status.code(), Code::kInvalidInput);
  EXPECT_NE(status.message().find("at least twice"), std::string::npos) << status.message();
  p.bur_shape = static_cast<cutting::BurShape>(99);
  EXPECT_NE(ValidateParams(p).message().find("99"), std::string::npos);
}

TEST(CoreParamsTest, EveryTruncationIsRefused) {
  ByteWriter out;
  WriteParams(Params(), out);
  for (size_t n = 0; n < out.size(); ++n) {
    ByteReader in(ByteView(out.bytes()).first(n));
    EXPECT_FALSE(ReadParams(in).ok()) << n;
  }
}

TEST(CoreParamsTest, MoreBursThanATickCanNameAreRefusedBeforeTheyAreRead) {
  ByteWriter out;
  WriteParams(Params(), out);
  Bytes bytes = out.Take();
  bytes.back() = kMaxBurs;
  bytes.resize(bytes.size() + kMaxBurs * kOtherBurBytes);
  ByteReader in(bytes);
  EXPECT_EQ(ReadParams(in).status().field(), "other_burs");
}

TEST(CoreParamsTest, ForeignCoreVersionIsNamed) {
  CoreParams p = Params();
  p.core_version = 99;
  Status status = ValidateParams(p);
  EXPECT_EQ(status.code(), Code::kVersion);
  EXPECT_NE(status.message().find("99"), std::string::npos);
}

TEST(CoreParamsTest, AnotherFormatIsRefusedByNumber) {
  ByteWriter out;
  WriteParams(Params(), out);
  Bytes bytes = out.Take();
  bytes[0] = 2;
  ByteReader in(bytes);
  auto read = ReadParams(in);
  EXPECT_EQ(read.status().code(), Code::kVersion);
  EXPECT_NE(read.status().message().find("of format 2"), std::string::npos)
      << read.status().message();
}

// Half a count unless the parameters say more.
TEST(ParamsTest, TheTipsCellIsHalfACountOrWhatTheParametersSay) {
  CoreParams p;
  p.resolution_nm = {9'000, 10'000, 20'001};
  EXPECT_EQ(TipCellOf(p).half_m, dvec3(9'000, 10'000, 20'001) * 1e-9 * 0.5);
  EXPECT_EQ(TipCellOf(p).ball_m, 0);
  p.cell_ball_nm = 7'795;
  EXPECT_EQ(TipCellOf(p).half_m, dvec3(0));
  EXPECT_EQ(TipCellOf(p).ball_m, 7'795 * 1e-9);
  p.cell_half_nm = {250, 251, 252};
  EXPECT_EQ(TipCellOf(p).half_m, dvec3(250, 251, 252) * 1e-9);
}

// A device with less than half of the damping that Kc asks for and a tick of delay that nobody knows of, in a hand
// that only pushes.
struct SwingingDevice {
  static constexpr double kMass_kg = 0.15, kDamping_n_s_per_m = 1.4, kPush_n = 2;
  double z_m = 0.2e-3, speed_m_per_s = 0;
  double sent_n = 0;

  TickInput Reading() const { return At(0, 0, z_m); }
  void Step(double force_n, bool pushes) {
    const double felt_n = std::exchange(sent_n, force_n);
    constexpr int kSteps = 20;
    for (int i = 0; i < kSteps; ++i) {
      const double push = pushes ? kPush_n : 0;
      speed_m_per_s +=
          (felt_n - push - kDamping_n_s_per_m * speed_m_per_s) / kMass_kg * 1e-3 / kSteps;
      z_m += speed_m_per_s * 1e-3 / kSteps;
    }
  }
};

// Motors, so that a hand can swing with them.
CoreParams WithMotors() {
  CoreParams p = Params();
  p.friction_mn = {1, 1, 1};
  return p;
}

TEST(CoreTest, ASwingIsFlaggedAndHeldAndReplaysToTheBit) {
  Core core(WithMotors(), test::Block(50'000, 3e-3, 3e-3)),
      replay(WithMotors(), test::Block(50'000, 3e-3, 3e-3)),
      mouse(Params(), test::Block(50'000, 3e-3, 3e-3));
  SwingingDevice device;
  std::vector<TickInput> inputs;
  bool seen = false;
  double least_n = 1e9, most_n = 0;
  for (int tick = 0; tick < 2700; ++tick) {
    inputs.push_back(device.Reading());
    const TickOutput out = core.Step(inputs.back());
    device.Step(out.force_sent_n.z, tick > 600);
    const bool flagged = (out.witness.flags & kSwingSeen) != 0;
    EXPECT_TRUE(flagged || !seen) << "it stays, at tick " << tick;
    seen = flagged;
    if (tick < 2200) continue;
    least_n = std::min(least_n, out.force_sent_n.z);
    most_n = std::max(most_n, out.force_sent_n.z);
  }
  EXPECT_TRUE(seen);
  EXPECT_LT(most_n - least_n, 1.5);
  EXPECT_GT(least_n, 0.5 * SwingingDevice::kPush_n) << "the hand still feels what it pushes with";
  for (const TickInput& in : inputs) {
    replay.Step(in);
    ASSERT_EQ(mouse.Step(in).flags & kSwingSeen, 0) << "nobody feels its force";
  }
  EXPECT_EQ(replay.state_hash(), core.state_hash());
}

TEST(CoreTest, ACutWithoutASwingIsNotFlagged) {
  Core core(WithMotors(), test::Block(50'000, 3e-3, 3e-3));
  for (int tick = 0; tick < 6000; ++tick)
    ASSERT_EQ(core.Step(Stroke(tick)).flags & kSwingSeen, 0) << tick;
}

}  // namespace
}  // namespace enamel::core
