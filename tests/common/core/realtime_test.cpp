#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/core/core.h"
#include "common/cutting/cutter.h"
#include "tests/common/core/params.h"
#include "tests/common/cutting/burs.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/analytic_volume.h"

// The cost of a tick: no memory, and no more work than is stated.
namespace enamel::core {
namespace {

TEST(RealtimeTest, NoTickAllocates) {
  int32_t torque = 0;
  for (const cutting::Bur& bur : test::AllBurs()) {
    CoreParams p = test::ParamsFor(bur);
    p.peak_torque_un_m = torque = 200'000 - torque;  // every second bur on a six-axis device
    p.rotation_cell_urad = 300;
    p.soft_start_ticks = 20;
    p.rotational_kc_un_m_per_rad = 20'000;
    p.handpiece_stall_un_m = 2330;
    p.handpiece_tangential_permille = 300;
    p.shank_radius_nm = 800'000;
    p.chatter_cue_mn = p.contact_cue_mn = 200;
    p.cue_energy_nj = 100'000;
    p.other_burs = {{cutting::BurShape::kSphere, 500'000}};
    p.other_burs[0].rotational_kc_un_m_per_rad = p.rotational_kc_un_m_per_rad;
    Core core(p, test::Block(50'000, 3e-3, 3e-3));
    testing_support::AllocationGuard guard;
    for (int tick = 0; tick < 4000; ++tick) {
      TickInput in = test::Stroke(tick);
      if (tick % 700 == 699) in.gap_ticks = 1 + tick % 30;
      if (tick % 900 > 870) in.flags = 0;
      if (tick == 3500) in.flags |= kFaulted;
      // Changed in air, and in the tooth.
      in.flags |= BurFlags(tick < 300 || tick > 3800);
      double a = 2e-4 * std::sin(tick * 0.01);
      in.orientation = {static_cast<int16_t>(32767 * a), 0, 0, 32767};
      core.Step(in);
    }
    EXPECT_EQ(guard.count(), 0u) << cutting::BurShapeName(bur.shape);
    EXPECT_GT(core.removed()[1], 0) << cutting::BurShapeName(bur.shape);
  }
}

// However wild the hand and whatever the law.
TEST(RealtimeTest, WorkOfATickStaysWithinItsStatedBounds) {
  std::mt19937_64 random(17);
  int most_cuts = 0;
  for (auto law : {haptics::LawKind::kMaxwell, haptics::LawKind::kLeadMaxwell,
                   haptics::LawKind::kPaperDamping}) {
    CoreParams p = test::ParamsFor({cutting::BurShape::kCylinder, 0.3e-3, 1e-3});
    p.law = law;
    p.soft_start_ticks = 0;
    p.damping_mn_s_per_mm[1] = 1;  // hardly any: the bur goes where the hand goes
    p.peak_force_mn = 1000;
    p.rotational_kc_un_m_per_rad = 100'000;
    p.other_burs = {{cutting::BurShape::kSphere, 500'000}};
    cutting::Volume block = test::Block(100'000, 6e-3, 6e-3);
    block.Reserve();
    cutting::Volume copy = block;
    const size_t most_bricks = cutting::Cutter(copy, BursOf(p)).MaxBricks();
    Core core(p, block);
    for (int tick = 0; tick < 400; ++tick) {
      int span = 1 << (random() % 13);
      TickInput in;
      for (auto& c : in.counts)
        c = static_cast<int32_t>(random() % static_cast<uint64_t>(span)) - span / 2;
      in.counts[2] -= 300;
      for (auto& q : in.orientation) q = static_cast<int16_t>(random());
      in.flags = tick % 13 == 0 ? 0 : kBurOn;
      in.flags |= BurFlags(static_cast<size_t>(tick / 40 % 2));
      core.Step(in);
      const Core::Work& work = core.work();
      ASSERT_LE(work.moves, Core::kMaxMovesPerTick);
      ASSERT_LE(work.samples, Core::kMaxMovesPerTick);
      ASSERT_LE(work.cuts, Core::kMaxCutsPerTick);
      ASSERT_LE(static_cast<size_t>(work.bricks),
                (static_cast<size_t>(work.cuts) + 1) * most_bricks);
      most_cuts = std::max(most_cuts, work.cuts);
    }
  }
  EXPECT_GT(most_cuts, 50) << "the inputs are not wild";
}

// Three ticks in four cut nothing at the pace of real work, and no brick is visited twice for one
// pose.
TEST(RealtimeTest, OrdinaryCuttingIsFarFromTheBounds) {
  CoreParams p = test::ParamsFor({cutting::BurShape::kCylinder, 0.6e-3, 4e-3});
  Core core(p, test::Block(50'000, 3e-3, 3e-3));
  int cuts = 0, samples = 0;
  for (int tick = 0; tick < 6000; ++tick) {
    core.Step(test::Stroke(tick));
    cuts += core.work().cuts;
    samples += core.work().samples;
    ASSERT_LE(core.work().cuts, 2);
    ASSERT_LE(core.work().samples, 2);
  }
  EXPECT_GT(cuts, 50);
  EXPECT_LT(cuts, 1500);
}

}  // namespace
}  // namespace enamel::core
