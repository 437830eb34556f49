#include <gtest/gtest.h>

#include "common/haptics/coupling.h"
#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

trace::Tick TickAt(int32_t x_10nm, int32_t force_100un) {
  trace::Tick tick;
  tick.witness.anchor_10nm = {x_10nm, 0, 0};
  tick.witness.force_sent_100un = {0, force_100un, 0};
  return tick;
}

core::TickOutput OutputOf(const trace::Tick& tick, int64_t removed) {
  core::TickOutput out;
  out.witness = tick.witness;
  out.removed[1] = removed;
  return out;
}

TEST(ProcessRecorderTest, PathIsTheLengthOfTheAnchorsWayWithoutJumpsAfterGaps) {
  ProcessRecorder recorder(SomeParams());
  for (int i = 0; i <= 100; ++i) recorder.AddRecorded(TickAt(i * 100, 0));  // 1 um each
  trace::Tick after_gap = TickAt(500'000, 0);                               // 4.9 mm away
  after_gap.input.gap_ticks = 7;
  after_gap.witness.flags = core::kAnchorReset;
  recorder.AddRecorded(after_gap);
  EXPECT_NEAR(recorder.anchor_path_m(), 100e-6, 1e-15);
  EXPECT_EQ(recorder.gap_ticks(), 7u);
  EXPECT_DOUBLE_EQ(recorder.duration_s(), 0.109);
}

// What the hand pressed with is what a cue was added to, and that is the force computed.
TEST(ProcessRecorderTest, TouchCuesAreNotTheStudentsForce) {
  ProcessRecorder with(SomeParams()), without(SomeParams());
  for (int i = 1; i <= 400; ++i) {
    trace::Tick tick = TickAt(0, i * 10);
    tick.witness.force_computed_100un = {0, i * 20, 0};  // a bound has changed what was sent
    without.Add(tick, OutputOf(tick, 1));
    if (i % 3 != 0) {
      tick.witness.force_computed_100un = tick.witness.force_sent_100un;
      tick.witness.force_sent_100un = {900, i * 10 + 800, -700};
      tick.witness.flags = core::kTouchCue;
    }
    with.Add(tick, OutputOf(tick, 1));
  }
  EXPECT_EQ(with.force_sent_p95_n(), without.force_sent_p95_n());
  EXPECT_EQ(with.force_sent_max_n(), without.force_sent_max_n());
  EXPECT_EQ(with.force_sent_mean_cutting_n(), without.force_sent_mean_cutting_n());
  for (size_t i = 0; i < with.samples().size(); ++i) {
    EXPECT_EQ(with.samples()[i].force_n, without.samples()[i].force_n);
  }
}

TEST(ProcessRecorderTest, ForceFiguresAreThoseOfAKnownDistribution) {
  ProcessRecorder recorder(SomeParams());
  // Forces 0.01, 0.02 … 1.00 N, the upper half while cutting, and as many ticks in the air.
  for (int i = 1; i <= 100; ++i) {
    trace::Tick tick = TickAt(0, i * 100);
    recorder.Add(tick, OutputOf(tick, i > 50 ? 9 : 0));
    trace::Tick air = TickAt(0, 0);
    recorder.Add(air, OutputOf(air, 0));
  }
  EXPECT_NEAR(recorder.force_sent_p95_n(), 0.95, 1e-9);
  EXPECT_NEAR(recorder.force_sent_max_n(), 1.0, 1e-12);
  EXPECT_NEAR(recorder.force_sent_mean_cutting_n(), 0.755, 1e-9);  // mean of 0.51 … 1.00
  EXPECT_EQ(recorder.ticks(), 200u);
}

// A stroke of a second that is cut every 20 ms, whatever the rate, and a second in air.
TEST(ProcessRecorderTest, CuttingTimeDoesNotCountTicksFromCoreVersion4On) {
  for (uint32_t rate : {1000u, 4000u, 8000u}) {
    for (uint32_t version : {3u, 4u}) {
      core::CoreParams params = SomeParams();
      params.rate_hz = rate;
      params.core_version = version;
      ProcessRecorder recorder(params);
      for (uint32_t i = 0; i < 2 * rate; ++i) {
        trace::Tick tick = TickAt(0, 100);
        recorder.Add(tick, OutputOf(tick, i < rate && i % (rate / 50) == 0 ? 9 : 0));
      }
      // Before: one tick in 20 ms. Since: the last 50 ms begin 20 ms before the stroke's end.
      EXPECT_DOUBLE_EQ(recorder.cutting_s(), version == 3 ? 50.0 / rate : 1.03) << rate;
    }
  }
}

TEST(ProcessRecorderTest, CountsLateAndBoundedTicks) {
  ProcessRecorder recorder(SomeParams());
  trace::Tick tick = TickAt(0, 10);
  tick.input.flags = core::kLateTick;
  recorder.AddRecorded(tick);
  tick.input.flags = 0;
  tick.witness.flags = haptics::kPeakBounded;
  recorder.AddRecorded(tick);
  recorder.AddRecorded(tick);
  EXPECT_EQ(recorder.late_ticks(), 1u);
  EXPECT_EQ(recorder.bounded_ticks(), 2u);
}

TEST(ProcessRecorderTest, SamplesAreAtMostFiftyPerSecondWithTheMeanForce) {
  ProcessRecorder recorder(SomeParams());
  for (int i = 0; i < 1000; ++i) recorder.AddRecorded(TickAt(i * 10, (i % 20) * 100));
  ASSERT_EQ(recorder.samples().size(), 50u);
  for (size_t k = 0; k < 50; ++k) {
    const PathSample& s = recorder.samples()[k];
    EXPECT_NEAR(s.time_s, 0.02 * static_cast<double>(k), 1e-12);
    EXPECT_NEAR(s.anchor_m.x, 1e-3 + 2e-6 * static_cast<double>(k), 1e-12) << "origin 1 mm";
    EXPECT_NEAR(s.force_n.y, 0.095, 1e-9);  // mean of 0, 0.01 … 0.19
  }
}

TEST(ProcessRecorderTest, ARecordingAloneGivesTheSamplesOfTheReplay) {
  ProcessRecorder replayed(SomeParams()), recorded(SomeParams());
  for (int i = 0; i < 500; ++i) {
    trace::Tick tick = TickAt(i * 37, i * 3);
    replayed.Add(tick, OutputOf(tick, i));
    recorded.AddRecorded(tick);
  }
  ASSERT_EQ(replayed.samples().size(), recorded.samples().size());
  for (size_t i = 0; i < recorded.samples().size(); ++i) {
    EXPECT_EQ(replayed.samples()[i].anchor_m, recorded.samples()[i].anchor_m);
    EXPECT_EQ(replayed.samples()[i].force_n, recorded.samples()[i].force_n);
  }
  EXPECT_EQ(replayed.anchor_path_m(), recorded.anchor_path_m());
}

TEST(ProcessRecorderTest, AnEmptyRecordingHasNoForceAndNoTime) {
  ProcessRecorder recorder(SomeParams());
  EXPECT_EQ(recorder.force_sent_p95_n(), 0);
  EXPECT_EQ(recorder.duration_s(), 0);
  EXPECT_TRUE(recorder.samples().empty());
}

}  // namespace
}  // namespace enamel::scoring
