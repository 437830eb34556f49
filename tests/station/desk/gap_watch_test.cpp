#include <gtest/gtest.h>

#include "station/desk/watch/tick_feed.h"

namespace enamel::station::desk {
namespace {

constexpr uint32_t kRate = 1000;
constexpr auto kShown = static_cast<uint64_t>(GapWatch::kShown_s * kRate),
               kCalm = static_cast<uint64_t>(GapWatch::kCalm_s * kRate);

Snapshot At(uint64_t ticks, uint64_t gaps, bool suspended = false) {
  Snapshot s;
  s.counters.ticks = ticks;
  s.counters.gap_ticks = gaps;
  if (suspended) s.output_flags = core::kSuspended;
  return s;
}

TEST(GapWatchTest, AWholeAttemptHasNothingToSay) {
  GapWatch watch(kRate);
  for (uint64_t t = 1; t < 5000; ++t) EXPECT_EQ(watch.Look(At(t, 0, t < 100)), 0u);
}

TEST(GapWatchTest, AGapIsToldForAWhileAndNotForTheRestOfTheAttempt) {
  GapWatch watch(kRate);
  for (uint64_t t = 1; t <= 100; ++t) watch.Look(At(t, 0));
  for (uint64_t t = 101; t < 101 + kShown; ++t) {
    ASSERT_EQ(watch.Look(At(t, 7)), render::kWarnGap) << t;
  }
  EXPECT_EQ(watch.Look(At(101 + kShown, 7)), 0u);
  EXPECT_EQ(watch.Look(At(102 + kShown, 9)), render::kWarnGap);
}

// A hand that pressed moves on while it feels nothing, and the core then waits for free air.
TEST(GapWatchTest, AGapThatSwitchedTheForceOffIsToldUntilItIsOnAgain) {
  GapWatch watch(kRate);
  for (uint64_t t = 1; t <= 100; ++t) watch.Look(At(t, 0));
  uint64_t t = 101;
  for (; t < 101 + 3 * kShown; ++t) {
    ASSERT_EQ(watch.Look(At(t, 20, true)), render::kWarnResumed) << t;
  }
  EXPECT_EQ(watch.Look(At(++t, 20)), 0u);
  // Switched off later for another reason, as a changed bur's.
  EXPECT_EQ(watch.Look(At(++t, 20, true)), 0u);
}

// The fault ends when the device is back, but the force only in free air.
TEST(GapWatchTest, AForceThatIsOffAfterAFaultIsToldOnceTheFaultSaysNothing) {
  for (const uint64_t gaps : {0u, 7u}) {
    GapWatch watch(kRate);
    watch.Look(At(1, 0));
    Snapshot faulted = At(2, gaps, true);
    faulted.fault = Fault::kUnplugged;
    EXPECT_NE(watch.Look(faulted), render::kWarnResumed);
    uint64_t t = 3;
    for (; t < 3 + 2 * kShown; ++t) {
      ASSERT_EQ(watch.Look(At(t, gaps, true)), render::kWarnResumed) << t;
    }
    EXPECT_EQ(watch.Look(At(t, gaps)), 0u);
    EXPECT_EQ(watch.Look(At(t + 1, gaps, true)), 0u);
  }
}

TEST(GapWatchTest, ResumedIsToldCalmlyUntilTheForceIsOn) {
  GapWatch watch(kRate);
  uint64_t t = 60'001;
  for (; t <= 60'000 + 3 * kShown; ++t) {
    ASSERT_EQ(watch.Look(At(t, 90'000, true)), render::kWarnResumed) << t;
  }
  EXPECT_EQ(watch.Look(At(++t, 90'000)), 0u);
  // Shown once: when suspended again, the attempt is not resumed again.
  EXPECT_EQ(watch.Look(At(++t, 90'000, true)), 0u);
  EXPECT_EQ(watch.Look(At(++t, 90'004)), render::kWarnGap);
}

TEST(GapWatchTest, ResumedIsToldAWhileAlsoWhenTheForceIsOnAtOnce) {
  GapWatch watch(kRate);
  EXPECT_EQ(watch.Look(At(501, 3)), render::kWarnResumed);
  EXPECT_EQ(watch.Look(At(500 + kCalm, 3)), render::kWarnResumed);
  EXPECT_EQ(watch.Look(At(501 + kCalm, 3)), 0u);
}

}  // namespace
}  // namespace enamel::station::desk
