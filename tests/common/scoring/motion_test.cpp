#include "common/scoring/movement/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace enamel::scoring {
namespace {

constexpr double kRate_hz = 50;

// Strokes to and fro over 4 x 3 mm whose lengths, heights and pauses are the hand's own.
struct Hand {
  uint64_t seed = 1;
  double noise_m = 0, wait_s = 0, speed = 1, seconds = 120;
};

std::vector<PathSample> Recorded(const Hand& hand) {
  std::mt19937_64 own(hand.seed), noise(99);
  auto uniform = [](std::mt19937_64& g, double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(g() >> 11) * 0x1p-53;
  };
  std::vector<PathSample> out;
  double way_m = 0;
  auto put = [&](const dvec3& at, bool pressed) {
    dvec3 p = at;
    for (int k = 0; k < 3; ++k) p[k] += uniform(noise, -1.7, 1.7) * hand.noise_m;
    if (!out.empty()) way_m += std::sqrt(Dot(p - out.back().anchor_m, p - out.back().anchor_m));
    out.push_back(
        {static_cast<double>(out.size()) / kRate_hz, p, dvec3(0, 0, pressed ? 1.0 : 0.0), way_m});
  };
  for (int i = 0; i < hand.wait_s * kRate_hz; ++i) put(dvec3(0, 0, 5e-3), false);
  dvec3 from(0);
  double t_s = 0;
  while (t_s < hand.seconds) {
    const dvec3 to(uniform(own, -2e-3, 2e-3), uniform(own, -1.5e-3, 1.5e-3),
                   -2e-3 * t_s / hand.seconds + uniform(own, -0.2e-3, 0.2e-3));
    const double took_s = uniform(own, 0.8, 2.5);
    const int steps = static_cast<int>(took_s * kRate_hz / hand.speed);
    for (int i = 0; i < steps; ++i) put(from + (to - from) * (1.0 * i / steps), true);
    from = to;
    t_s += took_s;
  }
  return out;
}

Motion Of(const Hand& hand) {
  const auto motion = MotionOf(Recorded(hand));
  EXPECT_TRUE(motion.has_value());
  return motion.value_or(Motion{});
}

// Others on the same exercise.
std::vector<Motion> Class() {
  std::vector<Motion> out;
  for (uint64_t seed = 10; seed < 20; ++seed) out.push_back(Of({seed}));
  return out;
}

// The nearness of `copy` in a class that includes the original.
Nearness Beside(const Hand& copy) {
  std::vector<Motion> others = Class();
  others.insert(others.begin() + 4, Of({1}));
  const auto out = NearnessTo(Of(copy), others);
  EXPECT_TRUE(out.has_value());
  return out.value_or(Nearness{});
}

TEST(MotionTest, TheSameMotionIsNowhereElse) {
  const Nearness same = Beside({1});
  EXPECT_EQ(same.nearest_m, 0);
  EXPECT_EQ(same.nearest, 4u);
  EXPECT_EQ(same.others, 11u);
  EXPECT_TRUE(IsWorthALook(same));
}

TEST(MotionTest, ACopyWithNoiseIsNear) {
  for (double um : {10.0, 50.0, 200.0}) {
    const Nearness noisy = Beside({1, um * 1e-6});
    EXPECT_EQ(noisy.nearest, 4u) << um;
    EXPECT_LT(noisy.nearest_m, um * 1e-6) << um;
    EXPECT_TRUE(IsWorthALook(noisy)) << um;
  }
}

// A preset path is compared with alone: no class says how far others are.
TEST(MotionTest, AReplayedReferenceWithJitterIsWorthALookAndAnotherHandIsNot) {
  const Motion reference[] = {Of({1})};
  for (double um : {10.0, 50.0, 100.0}) {
    EXPECT_TRUE(IsWorthALook(*NearnessTo(Of({1, um * 1e-6}), reference))) << um;
  }
  EXPECT_FALSE(IsWorthALook(*NearnessTo(Of({1, 200e-6}), reference))) << "found among others only";
  for (uint64_t seed = 10; seed < 40; ++seed) {
    EXPECT_FALSE(IsWorthALook(*NearnessTo(Of({seed}), reference))) << seed;
  }
}

TEST(MotionTest, ACopyThatWaitsFirstIsTheSame) {
  const Nearness late = Beside({1, 0, 17});
  EXPECT_EQ(late.nearest, 4u);
  EXPECT_LT(late.nearest_m, 20e-6);
}

TEST(MotionTest, ASlowerOrFasterCopyIsNear) {
  for (double speed : {0.5, 0.8, 1.3, 2.0}) {
    const Nearness other = Beside({1, 20e-6, 3, speed});
    EXPECT_EQ(other.nearest, 4u) << speed;
    EXPECT_TRUE(IsWorthALook(other)) << speed << ": " << other.nearest_m;
  }
}

TEST(MotionTest, AnotherHandOnTheSameExerciseIsNotNear) {
  const std::vector<Motion> others = Class();
  for (uint64_t seed = 30; seed < 40; ++seed) {
    const auto honest = NearnessTo(Of({seed}), others);
    ASSERT_TRUE(honest.has_value());
    EXPECT_FALSE(IsWorthALook(*honest)) << honest->nearest_m << " of " << honest->median_m;
    EXPECT_GT(honest->nearest_m, 0.5 * honest->median_m);
  }
}

TEST(MotionTest, DistanceIsTheWayBetweenParallelMotions) {
  std::vector<PathSample> aside = Recorded({1});
  for (PathSample& s : aside) s.anchor_m.z += 0.4e-3;
  const auto moved = MotionOf(aside);
  ASSERT_TRUE(moved.has_value());
  // Never more, and less only where another moment was nearer.
  EXPECT_LE(MotionDistance_m(Of({1}), *moved), 0.4e-3 + 1e-9);
  EXPECT_GT(MotionDistance_m(Of({1}), *moved), 0.3e-3);
  EXPECT_NEAR(MotionDistance_m(Of({1}), Of({2})), MotionDistance_m(Of({2}), Of({1})), 1e-9);
}

TEST(MotionTest, AHandThatHardlyPressedHasNoMotion) {
  EXPECT_FALSE(MotionOf({}).has_value());
  Hand brief;
  brief.seconds = 3;
  EXPECT_FALSE(MotionOf(Recorded(brief)).has_value());
  std::vector<PathSample> still(3000, PathSample{0, dvec3(1e-3), dvec3(0, 0, 1), 0});
  for (size_t i = 0; i < still.size(); ++i) still[i].time_s = static_cast<double>(i) / kRate_hz;
  EXPECT_FALSE(MotionOf(still).has_value());
}

TEST(MotionTest, WithoutMotorsAllOfTheTimeCounts) {
  std::vector<PathSample> samples = Recorded({1});
  for (PathSample& s : samples) s.force_n = dvec3(0);
  EXPECT_TRUE(MotionOf(samples).has_value());
}

TEST(MotionTest, AGapIsNoTimeThatWasPressed) {
  std::vector<PathSample> samples = Recorded({1, 0, 0, 1, 3});
  for (size_t i = samples.size() / 2; i < samples.size(); ++i) samples[i].time_s += 60;
  EXPECT_FALSE(MotionOf(samples).has_value());
}

TEST(MotionTest, NobodyElseIsNoNearness) { EXPECT_FALSE(NearnessTo(Of({1}), {}).has_value()); }

TEST(MotionTest, StoredMotionIsReadBackAndAnythingElseIsRefused) {
  const Motion motion = Of({1});
  Bytes bytes = EncodeMotion(motion);
  const auto back = DecodeMotion(bytes);
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(*back, motion);
  EXPECT_EQ(DecodeMotion({}).status().code(), Code::kInvalidInput);
  EXPECT_EQ(DecodeMotion(ByteView(bytes).first(100)).status().code(), Code::kInvalidInput);
  bytes.push_back(0);
  EXPECT_EQ(DecodeMotion(bytes).status().code(), Code::kInvalidInput);
  bytes[0] = 2;
  EXPECT_EQ(DecodeMotion(bytes).status().code(), Code::kVersion);
}

}  // namespace
}  // namespace enamel::scoring
