#include "common/scene/delay.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/builtin/builtin.h"
#include "common/scene/plan.h"

namespace enamel::scene {
namespace {

using From = DelayUsed::From;

DeviceProfile Phantom() { return BuiltinProfiles()[1]; }

Calibration Measured(int64_t ticks, int64_t rate_hz = 1000) {
  Calibration c;
  c.rate_hz = rate_hz;
  c.bus_delay_ticks = scene::Measured{ticks, 0, 8};
  return c;
}

TEST(DelayTest, AnAttachedDeviceThatNobodyMeasuredHasATick) {
  DeviceProfile profile = Phantom();
  EXPECT_EQ(DelayOfAttached(profile, nullptr, 1000), (DelayUsed{1, From::kAssumed, {}}));
  profile.bus_delay_ticks.value = 3;  // said, not measured: no less than that
  EXPECT_EQ(DelayOfAttached(profile, nullptr, 1000), (DelayUsed{3, From::kAssumed, {}}));
  // A calibration that did not measure it says nothing of it.
  Calibration other;
  other.mass_g = scene::Measured{45, 1, 8};
  EXPECT_EQ(DelayOfAttached(Phantom(), &other, 1000), (DelayUsed{1, From::kAssumed, {}}));
}

TEST(DelayTest, WhatWasMeasuredLiftsTheTickAndTheUnitsOwnMeasurementComesFirst) {
  DeviceProfile profile = Phantom();
  profile.delay_measured = true;
  EXPECT_EQ(DelayOfAttached(profile, nullptr, 1000), (DelayUsed{0, From::kProfile, {}}));
  const Calibration two = Measured(2), none = Measured(0);
  EXPECT_EQ(DelayOfAttached(profile, &two, 1000), (DelayUsed{2, From::kCalibration, {}}));
  EXPECT_EQ(DelayOfAttached(Phantom(), &none, 1000), (DelayUsed{0, From::kCalibration, {}}));
}

TEST(DelayTest, ADelayIsATimeAndIsRoundedUpAtAnotherRate) {
  const Calibration slow = Measured(1, 1000), fast = Measured(3, 4000);
  EXPECT_EQ(DelayOfAttached(Phantom(), &slow, 4000).ticks, 4);
  EXPECT_EQ(DelayOfAttached(Phantom(), &fast, 1000).ticks, 1);
  EXPECT_EQ(DelayOfAttached(Phantom(), &slow, 500).ticks, 1);
}

AnswerTime Answers(int64_t p99_us) { return {p99_us / 2, p99_us, 500}; }

TEST(DelayTest, AnswersCountInWholeTicksOfTheirNinetyNinthPartAndOfTheHoldUntilTheNext) {
  EXPECT_EQ(AnswerTicks(Answers(90), 1000), 1);
  EXPECT_EQ(AnswerTicks(Answers(1000), 1000), 1);
  EXPECT_EQ(AnswerTicks(Answers(1001), 1000), 2);
  EXPECT_EQ(AnswerTicks(Answers(1001), 4000), 5 + 2 - 1);  // 1.001 and 0.5 ms, ticks of 0.25 ms
  // All answers take n ticks: the force for a pose ends 2 n ticks after it was read.
  for (int64_t n : {1, 2, 3, 5}) {
    EXPECT_EQ(AnswerTicks({n * 1000, n * 1000, 500}, 1000) + 1, 2 * n);
  }
}

TEST(DelayTest, PosesThatComeMoreSlowlyThanTheTicksAreATickLateForEachThatTheyMiss) {
  struct Case {
    int64_t hz, rate_hz, ticks;
  };
  for (const Case& c : {Case{4000, 1000, 0},
                        {1000, 1000, 0},
                        {990, 1000, 0},
                        {800, 1000, 1},
                        {500, 1000, 1},
                        {250, 1000, 3},
                        {1000, 4000, 3},
                        {1000, 500, 0}}) {
    const int64_t us = 1'000'000 / c.hz;
    EXPECT_EQ(StaleTicks({us, us, 250}, c.rate_hz), c.ticks) << c.hz << ", " << c.rate_hz;
  }
  // One in a hundred is late: by a tick that is the loop's to count, by more it is the device's.
  EXPECT_EQ(StaleTicks({1000, 1900, 250}, 1000), 0);
  EXPECT_EQ(StaleTicks({1000, 2900, 250}, 1000), 1);
}

TEST(DelayTest, SlowPosesComeOnTopOfWhatIsKnown) {
  const PosePeriod slow{4000, 4100, 125}, quick{1000, 1300, 250};
  DeviceProfile profile = Phantom();
  DelayUsed used = DelayOfAttached(profile, nullptr, 1000, {}, slow);
  EXPECT_EQ(used.ticks, 1 + 3);
  EXPECT_EQ(used.from, From::kPoses);
  EXPECT_EQ(used.poses, slow);
  const Calibration two = Measured(2);
  EXPECT_EQ(DelayOfAttached(profile, &two, 1000, {}, slow).ticks, 2 + 3);
  used = DelayOfAttached(profile, &two, 1000, {}, quick);
  EXPECT_EQ(used.ticks, 2);
  EXPECT_EQ(used.from, From::kCalibration);
  EXPECT_EQ(DelayOfAttached(profile, nullptr, 1000, {}, PosePeriod{900'000, 900'000, 20}).ticks,
            kMaxDelay_ticks);
}

TEST(DelayTest, SlowAnswersAddToWhatIsAssumedAndRaiseWhatWasMeasured) {
  DeviceProfile profile = Phantom();
  profile.bus_delay_ticks.value = 2;  // a tick for the answer, a tick behind it
  DelayUsed used = DelayOfAttached(profile, nullptr, 1000, Answers(90));
  EXPECT_EQ(used, (DelayUsed{2, From::kAssumed, Answers(90)}));
  used = DelayOfAttached(profile, nullptr, 1000, Answers(3050));
  EXPECT_EQ(used, (DelayUsed{4 + 1 + 1, From::kAnswers, Answers(3050)}));
  // A measurement has the tick behind the answers in it.
  const Calibration three = Measured(3);
  EXPECT_EQ(DelayOfAttached(profile, &three, 1000, Answers(2000)).from, From::kCalibration);
  EXPECT_EQ(DelayOfAttached(profile, &three, 1000, Answers(3050)),
            (DelayUsed{5, From::kAnswers, Answers(3050)}));
  profile.delay_measured = true;
  EXPECT_EQ(DelayOfAttached(profile, nullptr, 1000, Answers(3050)),
            (DelayUsed{5, From::kAnswers, Answers(3050)}));
  EXPECT_EQ(DelayOfAttached(profile, nullptr, 1000, Answers(900'000)).ticks, kMaxDelay_ticks);
}

// b = 1.75 N s/m: 2 b f = 3500 mN/mm, over 1, 4, 9, 16.
TEST(DelayTest, TheCouplingIsLoweredToWhatIsPassiveAndNeverRaised) {
  const int64_t passive[] = {3500, 875, 388, 218};
  for (int64_t d = 0; d < 4; ++d) {
    EXPECT_EQ(PassiveCoupling_mn_per_mm(Phantom(), 1000, d), passive[d]);
    auto delayed = WithDelay(Phantom(), 1000, d);
    ASSERT_TRUE(delayed.ok());
    EXPECT_EQ(delayed->coupling_mn_per_mm.value, std::min<int64_t>(2500, passive[d]));
    EXPECT_EQ(delayed->bus_delay_ticks.value, d);
  }
  DeviceProfile undamped = Phantom();
  undamped.damping_mn_s_per_m.value = 1;
  auto none = WithDelay(undamped, 1000, 1);
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.status().message().find("enamel-station calibrate"), std::string::npos);
}

// sigma7: 2 b_rot f = 1 N m/rad, over 1, 4, 9; and its coupling 0.8.
TEST(DelayTest, TheTorquesSpringIsLoweredWithTheCoupling) {
  const DeviceProfile sigma = BuiltinProfiles().back();
  ASSERT_TRUE(sigma.torque);
  const int64_t passive[] = {1'000'000, 250'000, 111'111};
  for (int64_t d = 0; d < 3; ++d) {
    EXPECT_EQ(PassiveTorque_un_m_per_rad(sigma, 1000, d), passive[d]);
    auto delayed = WithDelay(sigma, 1000, d);
    ASSERT_TRUE(delayed.ok());
    EXPECT_EQ(delayed->torque->coupling_un_m_per_rad.value, std::min<int64_t>(800'000, passive[d]));
    EXPECT_EQ(delayed->torque->peak_un_m.value, 200'000);
  }
  DeviceProfile undamped = sigma;
  undamped.torque->damping_un_m_s_per_rad.value = 0;
  EXPECT_EQ(WithDelay(undamped, 1000, 1).status().field(), "damping_un_m_s_per_rad");
}

TEST(DelayTest, ParametersOfAnyDelayAreTheExercisesAndStifferOnesAreNot) {
  auto built = BuildBuiltinScene("block", 200'000);
  ASSERT_TRUE(built.ok());
  const Exercise exercise = ClassOneExercise(built->scene, {});
  for (int64_t d : {0, 1, 2, 7}) {
    auto profile = WithDelay(Phantom(), exercise.rate_hz, d);
    ASSERT_TRUE(profile.ok());
    auto params = CompilePlan(built->scene, exercise, *profile);
    ASSERT_TRUE(params.ok()) << params.status().message();
    EXPECT_TRUE(CheckParams(built->scene, exercise, Phantom(), *params).ok()) << d;
    for (int32_t off : {-1, 1}) {
      core::CoreParams other = *params;
      other.kc_mn_per_mm += off;
      Status refused = CheckParams(built->scene, exercise, Phantom(), other);
      EXPECT_EQ(refused.code(), Code::kConflict) << d << " " << off;
      EXPECT_EQ(refused.field(), "params");
    }
    core::CoreParams other = *params;
    other.peak_force_mn += 1;
    EXPECT_FALSE(CheckParams(built->scene, exercise, Phantom(), other).ok());
    // Touch cues that the exercise does not have, and others than it has.
    other = *params;
    other.chatter_cue_mn = 100;
    other.cue_energy_nj = 200'000;
    EXPECT_FALSE(CheckParams(built->scene, exercise, Phantom(), other).ok());
    Exercise cued = exercise;
    cued.touch_cues = {250, 100, 200, 1'000};
    params = CompilePlan(built->scene, cued, *profile);
    ASSERT_TRUE(params.ok());
    EXPECT_TRUE(CheckParams(built->scene, cued, Phantom(), *params).ok());
    params->cue_power_nw += 1;
    EXPECT_FALSE(CheckParams(built->scene, cued, Phantom(), *params).ok());
  }
}

}  // namespace
}  // namespace enamel::scene
