#include "station/hid/emulated_board.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/rate.h"
#include "station/loop/tick_loop.h"
#include "tests/support/block_plan.h"

namespace enamel::station::hid {
namespace {

struct Cut {
  test::BlockPlan block = test::MakeBlockPlan();
  scene::DeviceProfile profile = test::PlainProfile();
  EmulatedBoardSettings settings;

  // Down onto the block, in at 0.4 mm/s, and a stroke to the side.
  Cut() {
    settings.profile = profile;
    settings.kc_mn_per_mm =
        scene::LargestCouplingAt(profile, 8000, settings.delay_ticks).coupling_mn_per_mm;
    block.params.spring_on_board = true;
    block.params.kc_mn_per_mm = static_cast<int32_t>(settings.kc_mn_per_mm);
    const double top_m = block.CountsAbove(0) * 1e-9 * block.params.resolution_nm[2];
    settings.hand = [top_m](double t) {
      const double down = t < 0.4 ? 0.1e-3 : 0.1e-3 - 0.4e-3 * (t - 0.4);
      return dvec3(0.3e-3 * std::sin(2 * t), 0, top_m + down);
    };
  }
};

TEST(EmulatedBoardTest, ASpringThatTheInnerLoopDoesNotCarryIsRefusedWithTheLargest) {
  Cut cut;
  EXPECT_TRUE(EmulatedBoard::Make(cut.settings).ok());
  const std::string most = std::to_string(cut.settings.kc_mn_per_mm);
  ++cut.settings.kc_mn_per_mm;
  const auto refused = EmulatedBoard::Make(cut.settings);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.status().field(), "kc_mn_per_mm");
  EXPECT_NE(refused.status().message().find("1 to " + most), std::string::npos);
  // Slower inside, it carries less.
  --cut.settings.kc_mn_per_mm;
  cut.settings.inner_ticks = 1;
  EXPECT_FALSE(EmulatedBoard::Make(cut.settings).ok());
}

TEST(EmulatedBoardTest, ItsFeatureReportIsReadAsItIsMeant) {
  Cut cut;
  auto board = EmulatedBoard::Make(cut.settings);
  ASSERT_TRUE(board.ok());
  FeatureReport read;
  ASSERT_EQ(DecodeFeature(EncodeFeature((*board)->feature()), read), ReportError::kNone);
  EXPECT_EQ(read, (*board)->feature());
  EXPECT_EQ(read.spring_rate_hz, 8000);
  EXPECT_EQ(read.spring_delay_ticks, 1);
}

// The whole chain: loop, core and firmware, by reports as bytes; and a replay of what was recorded.
TEST(EmulatedBoardTest, TheLoopCutsWithTheBoardsSpringAndTheRecordingReplays) {
  Cut cut;
  auto made = EmulatedBoard::Make(cut.settings);
  ASSERT_TRUE(made.ok());
  EmulatedBoard& board = **made;
  core::Core core(cut.block.params, cut.block.volume), replayed(cut.block.params, cut.block.volume);
  SampleRing ring(4);
  TickLoop loop(board, core, ring, {1000, false, true});
  double most_n = 0;
  for (int k = 0; k < 3000; ++k) {
    board.Hear(k % 40 != 3);
    loop.Tick();
    Sample sample;
    ASSERT_TRUE(ring.Pop(sample));
    ASSERT_EQ(replayed.Step(sample.tick.input).witness, sample.tick.witness) << k;
    ASSERT_EQ(replayed.state_hash(), sample.state_hash) << k;
    for (int i = 0; i < 3; ++i) {
      ASSERT_NEAR(sample.tick.witness.force_sent_mn[static_cast<size_t>(i)] * 1e-3,
                  board.force_n()[i], 0.6e-3)
          << k;
    }
    most_n = std::max(most_n, glm::length(board.force_n()));
  }
  EXPECT_EQ(loop.fault(), Fault::kNone);
  EXPECT_GT(most_n, 0.3);
  int64_t removed = 0;
  for (int64_t r : core.removed()) removed += r;
  EXPECT_GT(removed, 0);
}

TEST(EmulatedBoardTest, WithoutTheLoopItsForceEndsByItself) {
  Cut cut;
  auto made = EmulatedBoard::Make(cut.settings);
  ASSERT_TRUE(made.ok());
  EmulatedBoard& board = **made;
  core::Core core(cut.block.params, cut.block.volume);
  SampleRing ring(4);
  TickLoop loop(board, core, ring, {1000, false, true});
  Sample sample;
  for (int k = 0; k < 2000; ++k) {
    loop.Tick();
    ring.Pop(sample);
  }
  ASSERT_GT(glm::length(board.force_n()), 0.3);
  for (int k = 0; k < 1000; ++k) board.ReadSample();
  const double cell_m = cut.block.params.resolution_nm[0] * 1e-9;
  EXPECT_LE(
      glm::length(board.force_n()),
      std::sqrt(3.0) * 0.5 * cell_m * static_cast<double>(cut.settings.kc_mn_per_mm) * (1 + 1e-9));
  for (int k = 0; k < 2100; ++k) board.ReadSample();
  EXPECT_EQ(board.force_n(), dvec3(0));
}

}  // namespace
}  // namespace enamel::station::hid
