#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/haptics/coupling.h"
#include "common/scoring/metrics.h"
#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

trace::Tick TickAt(int32_t x_100nm, int32_t force_mn) {
  trace::Tick tick;
  tick.witness.anchor_100nm = {x_100nm, 0, 0};
  tick.witness.force_sent_mn = tick.witness.force_computed_mn = {0, force_mn, 0};
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
  for (int i = 0; i <= 100; ++i) recorder.AddRecorded(TickAt(i * 10, 0));  // 1 um each
  trace::Tick after_gap = TickAt(50'000, 0);                               // 4.9 mm away
  after_gap.input.gap_ticks = 7;
  after_gap.witness.flags = core::kAnchorReset;
  recorder.AddRecorded(after_gap);
  EXPECT_NEAR(recorder.anchor_path_m(), 100e-6, 1e-15);
  EXPECT_EQ(recorder.gap_ticks(), 7u);
  EXPECT_DOUBLE_EQ(recorder.duration_s(), 0.109);
}

// The hand pressed with the force computed, before a cue was added to it.
TEST(ProcessRecorderTest, TouchCuesAreNotTheStudentsForce) {
  ProcessRecorder with(SomeParams()), without(SomeParams());
  for (int i = 1; i <= 400; ++i) {
    trace::Tick tick = TickAt(0, i);
    tick.witness.force_computed_mn = {0, i * 2, 0};
    tick.witness.flags = haptics::kPeakBounded;
    without.Add(tick, OutputOf(tick, 1));
    if (i % 3 != 0) {
      tick.witness.force_computed_mn = tick.witness.force_sent_mn;
      tick.witness.force_sent_mn = {90, i + 80, -70};
      tick.witness.flags = 0;
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
    trace::Tick tick = TickAt(0, i * 10);
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
TEST(ProcessRecorderTest, CuttingTimeDoesNotDependOnTheRate) {
  for (uint32_t rate : {1000u, 4000u, 8000u}) {
    core::CoreParams params = SomeParams();
    params.rate_hz = rate;
    ProcessRecorder recorder(params);
    for (uint32_t i = 0; i < 2 * rate; ++i) {
      trace::Tick tick = TickAt(0, 10);
      recorder.Add(tick, OutputOf(tick, i < rate && i % (rate / 50) == 0 ? 9 : 0));
    }
    // The last 50 ms begin 20 ms before the stroke's end.
    EXPECT_DOUBLE_EQ(recorder.cutting_s(), 1.03) << rate;
  }
}

TEST(ProcessRecorderTest, CountsLateAndBoundedTicks) {
  ProcessRecorder recorder(SomeParams());
  trace::Tick tick = TickAt(0, 1);
  tick.input.flags = core::kLateTick;
  recorder.AddRecorded(tick);
  tick.input.flags = 0;
  tick.witness.flags = haptics::kPeakBounded;
  recorder.AddRecorded(tick);
  recorder.AddRecorded(tick);
  EXPECT_EQ(recorder.late_ticks(), 1u);
  EXPECT_EQ(recorder.bounded_ticks(), 2u);
}

TEST(ProcessRecorderTest, RemembersThatHandAndDeviceSwung) {
  ProcessRecorder recorder(SomeParams());
  trace::Tick tick = TickAt(0, 1);
  recorder.AddRecorded(tick);
  EXPECT_FALSE(recorder.shook());
  tick.witness.flags = core::kSwingSeen;
  recorder.AddRecorded(tick);
  tick.witness.flags = 0;
  recorder.AddRecorded(tick);
  EXPECT_TRUE(recorder.shook());
}

// A late tick's gap, over which the force was held, is none; a fault that begins with a gap is one.
TEST(ProcessRecorderTest, CountsHowOftenTheForceWasTakenAway) {
  ProcessRecorder recorder(SomeParams());
  const auto add = [&](uint8_t flags, uint32_t gap_ticks, uint64_t expected) {
    trace::Tick tick = TickAt(0, 1);
    tick.input.flags = flags;
    tick.input.gap_ticks = gap_ticks;
    recorder.AddRecorded(tick);
    EXPECT_EQ(recorder.outages(), expected);
  };
  add(0, 0, 0);
  add(core::kLateTick | core::kHeldGap, 3, 0);
  add(0, 20, 1);
  add(0, 0, 1);
  add(core::kFaulted, 100, 2);
  add(core::kFaulted, 0, 2);
  add(core::kSoftRestart, 0, 2);
  add(core::kFaulted, 0, 3);
}

TEST(ProcessRecorderTest, SamplesAreAtMostFiftyPerSecondWithTheMeanForce) {
  ProcessRecorder recorder(SomeParams());
  for (int i = 0; i < 1000; ++i) recorder.AddRecorded(TickAt(i, (i % 20) * 10));
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

// Pressing from 0.1 to 0.3 s, from 0.5 to 0.7 s with a hop of 5 ms, and from 0.9 to 0.95 s; the
// first and the last cut.
TEST(ProcessRecorderTest, ContactsStrokesAndIdleTimeAreCountedAsPeopleCountThem) {
  ProcessRecorder recorder(SomeParams());
  for (int i = 0; i < 1200; ++i) {
    const bool first = i >= 100 && i < 300, last = i >= 900 && i < 950;
    const bool hop = i >= 600 && i < 605, middle = i >= 500 && i < 700 && !hop;
    trace::Tick tick = TickAt(0, first || middle || last ? 500 : 0);
    recorder.Add(tick, OutputOf(tick, first || last ? 3 : 0));
  }
  EXPECT_EQ(recorder.strokes().contacts(), 3u);
  EXPECT_EQ(recorder.strokes().Strokes().size(), 2u);
  EXPECT_NEAR(recorder.idle_s(), 1.2 - 0.2 - 0.2 - 0.05, 1e-12);
}

// Six tenths of the cutting at 10 degrees about x, four at 130 about y, and air at 90.
TEST(ProcessRecorderTest, AngulationIsTheBursAxisAgainstTheTooths) {
  ProcessRecorder recorder(SomeParams());
  EXPECT_EQ(recorder.angulation_mean_deg(), std::nullopt);
  auto put = [&](int ticks, double degrees, bool about_x, bool cutting) {
    const double half = degrees / 360 * std::numbers::pi;
    trace::Tick tick = TickAt(0, 10);
    tick.input.orientation = ToQuantised(
        {about_x ? std::sin(half) : 0, about_x ? 0 : std::sin(half), 0, std::cos(half)});
    for (int i = 0; i < ticks; ++i) recorder.Add(tick, OutputOf(tick, cutting ? 1 : 0));
  };
  put(6000, 10, true, true);
  put(4000, 130, false, true);
  EXPECT_NEAR(*recorder.angulation_mean_deg(), 0.6 * 10 + 0.4 * 130, 0.01);
  EXPECT_NEAR(*recorder.angulation_p95_deg(), 130, 0.1);
  put(4000, 90, true, false);
  EXPECT_NEAR(*recorder.angulation_mean_deg(), 0.6 * 10 + 0.4 * 130, 0.3) << "50 ms run on";
}

// 2 N against a hand that moves 3 mm on, then none as it comes back, then 1 N that pushes it 1.5
// mm.
TEST(ProcessRecorderTest, ImpulseAndWorkAreThoseOfAKnownPush) {
  ProcessRecorder recorder(SomeParams());
  int count = 0;
  auto move = [&](int ticks, int step, int32_t force_mn) {
    for (int i = 0; i < ticks; ++i) {
      trace::Tick tick = TickAt(0, 0);
      tick.input.counts[0] = count;  // of 30 um
      tick.witness.force_computed_mn = {force_mn, 0, 0};
      recorder.AddRecorded(tick);
      count += step;
    }
  };
  move(100, 1, -2000);
  move(100, -1, 0);
  move(50, 1, 1000);
  move(1, 0, 0);
  EXPECT_NEAR(recorder.work_j(), 2 * 3e-3 - 1 * 1.5e-3, 1e-12);
  EXPECT_NEAR(recorder.impulse_n_s(), 2 * 0.1 + 1 * 0.05, 1e-12);
  // A gap in which the hand went elsewhere is nobody's work.
  trace::Tick far = TickAt(0, 0);
  far.input.counts[0] = 10'000;
  far.witness.force_computed_mn = {-3000, 0, 0};
  far.witness.flags = core::kAnchorReset;
  recorder.AddRecorded(far);
  EXPECT_NEAR(recorder.work_j(), 4.5e-3, 1e-12);
}

TEST(ProcessRecorderTest, TheForcesRateIsThatOfARamp) {
  for (uint32_t rate : {1000u, 4000u}) {
    core::CoreParams params = SomeParams();
    params.rate_hz = rate;
    ProcessRecorder recorder(params);
    // Up by 1 N in 0.1 s and down in 0.2 s, over and over: 10 N/s, and 5 N/s two thirds of the
    // time.
    const auto period = static_cast<int>(rate * 3 / 10);
    for (int i = 0; i < 20 * period; ++i) {
      const double t = i % period / static_cast<double>(rate);
      const double force = 0.1 + (t < 0.1 ? 10 * t : 1 - 5 * (t - 0.1));
      recorder.AddRecorded(TickAt(0, static_cast<int32_t>(std::lround(force * 1e3))));
    }
    EXPECT_NEAR(recorder.force_rate_p95_n_per_s(), 10, 0.11) << rate;
  }
}

TEST(ProcessRecorderTest, TheOrderOfWorkIsByWhenHalfOfEachTissueWasGone) {
  ProcessRecorder recorder(SomeParams());
  for (int i = 0; i < 6000; ++i) {
    trace::Tick tick = TickAt(0, 10);
    if (i == 4000) tick.input.gap_ticks = 500;
    core::TickOutput output = OutputOf(tick, 0);
    using cutting::Tissue;
    if (i >= 1000 && i < 3000) output.removed[static_cast<size_t>(Tissue::kEnamel)] = 7;
    if (i == 5050) output.removed[static_cast<size_t>(Tissue::kDentin)] = 1;
    recorder.Add(tick, output);
  }
  EXPECT_NEAR(*recorder.half_removed_s(cutting::Tissue::kEnamel), 2.0, 0.051);
  EXPECT_NEAR(*recorder.half_removed_s(cutting::Tissue::kDentin), 5.55, 0.051) << "gaps included";
  EXPECT_EQ(recorder.half_removed_s(cutting::Tissue::kCaries), std::nullopt);
}

// Three reaches of least jerk, a blink of a touch and one reach with a stop on its way.
TEST(ProcessRecorderTest, SmoothnessIsThatOfTheMedianStroke) {
  ProcessRecorder recorder(SomeParams());
  auto reach = [&](double from_mm, double to_mm, int ticks) {
    for (int i = 0; i <= ticks; ++i) {
      const double t = i / static_cast<double>(ticks);
      const double x = from_mm + (to_mm - from_mm) * t * t * t * (10 - 15 * t + 6 * t * t);
      trace::Tick tick = TickAt(static_cast<int32_t>(std::lround(x * 1e4)), 100);
      core::TickOutput output = OutputOf(tick, 1);
      output.anchor.tip_m.x = x * 1e-3;
      recorder.Add(tick, output);
    }
  };
  auto lift = [&](double at_mm) {
    const trace::Tick air = TickAt(static_cast<int32_t>(std::lround(at_mm * 1e4)), 0);
    for (int i = 0; i < 300; ++i) recorder.Add(air, OutputOf(air, 0));
  };
  EXPECT_EQ(recorder.MeasureSmoothness().log_dimensionless_jerk, std::nullopt);
  for (int i = 0; i < 3; ++i) {
    reach(0, 40, 4000);
    lift(40);
  }
  reach(0, 1, 100);
  lift(1);
  reach(0, 20, 2000);
  reach(20, 40, 2000);
  lift(40);
  const auto smooth = recorder.MeasureSmoothness();
  EXPECT_NEAR(*smooth.log_dimensionless_jerk, -std::log(204.8), 0.1);
  std::vector<double> speed;
  for (int i = 0; i < 200; ++i) {
    const double t = (i + 0.5) / 200;
    speed.push_back(t * t * (1 - t) * (1 - t));
  }
  EXPECT_NEAR(*smooth.spectral_arc_length, *SpectralArcLength(speed, 50), 0.01);
}

// Ten counts of 30 um to either side at 10 Hz: 300 um / sqrt 2, in contact only.
TEST(ProcessRecorderTest, TremorIsTheHandsWhileItTouches) {
  ProcessRecorder recorder(SomeParams());
  auto tremble = [&](int ticks, double counts, int32_t force_mn) {
    for (int i = 0; i < ticks; ++i) {
      trace::Tick tick = TickAt(0, force_mn);
      tick.input.counts[1] =
          static_cast<int32_t>(std::lround(counts * std::sin(2 * std::numbers::pi * 0.01 * i)));
      recorder.Add(tick, OutputOf(tick, 0));
    }
  };
  tremble(3000, 40, 0);
  EXPECT_EQ(recorder.tremor_m(), std::nullopt);
  tremble(5000, 10, 200);
  EXPECT_NEAR(*recorder.tremor_m(), 300e-6 / std::sqrt(2), 5e-6);
}

// A thousand ticks, half with force: late, missing and bounded ones in known shares.
TEST(DisturbanceTest, SharesAreOfTicksOfTimeAndOfTicksWithForce) {
  auto of = [](int late, uint32_t gap, int bounded) {
    ProcessRecorder recorder(SomeParams());
    for (int i = 0; i < 1000; ++i) {
      trace::Tick tick = TickAt(0, i < 500 ? 10 : 0);
      if (i < late) tick.input.flags = core::kLateTick;
      if (i < bounded) tick.witness.flags = haptics::kPeakBounded;
      if (i == 700) tick.input.gap_ticks = gap;
      recorder.AddRecorded(tick);
    }
    return DisturbanceOf(recorder);
  };
  const Disturbance some = of(10, 250, 25);
  EXPECT_DOUBLE_EQ(some.late_percent, 1);
  EXPECT_DOUBLE_EQ(some.gap_percent, 20);
  EXPECT_DOUBLE_EQ(some.limited_percent, 5);
  EXPECT_TRUE(some.disturbed());
  EXPECT_FALSE(of(10, 0, 25).disturbed()) << "at the limits, not beyond them";
  EXPECT_TRUE(of(11, 0, 0).disturbed());
  EXPECT_TRUE(of(0, 11, 0).disturbed());
  EXPECT_TRUE(of(0, 0, 26).disturbed());
  EXPECT_FALSE(DisturbanceOf(ProcessRecorder(SomeParams())).disturbed());
}

TEST(ProcessRecorderTest, AnEmptyRecordingHasNoForceAndNoTime) {
  ProcessRecorder recorder(SomeParams());
  EXPECT_EQ(recorder.force_sent_p95_n(), 0);
  EXPECT_EQ(recorder.duration_s(), 0);
  EXPECT_TRUE(recorder.samples().empty());
}

}  // namespace
}  // namespace enamel::scoring
