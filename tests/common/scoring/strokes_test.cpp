#include "common/scoring/movement/strokes.h"

#include <gtest/gtest.h>

#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

struct StrokeHand {
  StrokeRecorder recorder{SomeParams()};

  // `ticks` ticks that press with `force` and remove `removed` each.
  void Go(int ticks, int32_t force, int64_t removed, uint32_t gap = 0, uint16_t flags = 0) {
    for (int i = 0; i < ticks; ++i) {
      trace::Tick tick;
      core::TickOutput out;
      if (i == 0) tick.input.gap_ticks = gap;
      if (i == 0) out.witness.flags = flags;
      out.witness.force_computed_mn = {0, 0, force};
      out.removed[1] = removed;
      recorder.Add(tick, out);
    }
  }
};

TEST(StrokeRecorderTest, ALiftOfMoreThanATenthOfASecondEndsAStroke) {
  ASSERT_EQ(SomeParams().rate_hz, 1000u);
  StrokeHand hand;
  hand.Go(50, 0, 0);
  hand.Go(200, 100, 3);  // 50..249
  hand.Go(99, 0, 0);     // a hop
  hand.Go(10, 100, 0);   // ..358
  hand.Go(150, 0, 0);
  hand.Go(20, 100, 0);  // touched and not cut: a contact
  hand.Go(150, 0, 0);
  hand.Go(30, 0, 5);  // 679..708: what a bur cuts without force is a stroke too
  const auto strokes = hand.recorder.Strokes();
  ASSERT_EQ(strokes.size(), 2u);
  EXPECT_EQ(strokes[0].first_tick, 50u);
  EXPECT_EQ(strokes[0].last_tick, 358u);
  EXPECT_EQ(strokes[0].removed[1], 600);
  EXPECT_EQ(strokes[1].first_tick, 679u);
  EXPECT_EQ(strokes[1].last_tick, 708u);
  EXPECT_EQ(hand.recorder.contacts(), 3u);
  EXPECT_DOUBLE_EQ(hand.recorder.contact_s(), (309 + 20 + 30) / 1000.0);
  EXPECT_EQ(StrokeRecorder::NumberAt(strokes, 49), 0u);
  EXPECT_EQ(StrokeRecorder::NumberAt(strokes, 300), 1u);
  EXPECT_EQ(StrokeRecorder::NumberAt(strokes, 359), 0u);
  EXPECT_EQ(StrokeRecorder::NumberAt(strokes, 708), 2u);
  EXPECT_EQ(StrokeRecorder::NumberAt({}, 0), 0u);
}

TEST(StrokeRecorderTest, AGapEndsAStrokeAndCountsAsTime) {
  StrokeHand hand;
  hand.Go(10, 100, 1);
  hand.Go(10, 100, 1, 500, core::kAnchorReset);
  hand.Go(5, 100, 1, 2);  // a late tick's gap, and the stroke goes on
  const auto strokes = hand.recorder.Strokes();
  ASSERT_EQ(strokes.size(), 2u);
  EXPECT_DOUBLE_EQ(strokes[0].last_s, 0.009);
  EXPECT_DOUBLE_EQ(strokes[1].first_s, 0.510);
  EXPECT_EQ(strokes[1].last_tick, 24u);
  EXPECT_DOUBLE_EQ(strokes[1].last_s, 0.526);
  EXPECT_DOUBLE_EQ(hand.recorder.TimeOf_s(9), 0.009);
  EXPECT_DOUBLE_EQ(hand.recorder.TimeOf_s(19), 0.519);
  EXPECT_DOUBLE_EQ(hand.recorder.TimeOf_s(20), 0.522);
}

TEST(StrokeRecorderTest, NothingTouchedIsNoStroke) {
  StrokeHand hand;
  EXPECT_TRUE(hand.recorder.Strokes().empty());
  hand.Go(1000, 0, 0);
  EXPECT_TRUE(hand.recorder.Strokes().empty());
  EXPECT_EQ(hand.recorder.contacts(), 0u);
  EXPECT_EQ(hand.recorder.contact_s(), 0);
}

}  // namespace
}  // namespace enamel::scoring
