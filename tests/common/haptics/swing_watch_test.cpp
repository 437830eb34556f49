#include "common/haptics/swing_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace enamel::haptics {
namespace {

constexpr double kTick_s = 1e-3;

// When a force over time trips the watch, s; -1: never in `seconds`.
double TrippedAt(const std::function<dvec3(double)>& force, double seconds = 2,
                 SwingWatchParams params = {}) {
  SwingWatch watch(params);
  for (int i = 0; i * params.tick_s < seconds; ++i) {
    watch.Tick(force(i * params.tick_s));
    if (watch.tripped()) return i * params.tick_s;
  }
  return -1;
}

std::function<dvec3(double)> Sine(double hz, double amplitude_n, const dvec3& way = {1, 0, 0}) {
  return [=](double t) { return way * (amplitude_n * std::sin(2 * M_PI * hz * t)); };
}

// Two stages pass ((f/f0)^2 / (1 + (f/f0)^2)) of a frequency: what is below least_n after that is nothing.
TEST(SwingWatchTest, TripsOnASineThatPassesTheBandAndOnNoWeakerOne) {
  for (double hz : {10.0, 15.0, 20.0, 30.0, 60.0}) {
    const double r = hz / SwingWatch::kBand_hz, passed = r * r / (1 + r * r);
    const double least_n = SwingWatchParams{}.least_n / passed;
    EXPECT_GT(TrippedAt(Sine(hz, 1.15 * least_n)), 0) << hz;
    // Where force sets in the first half cycles are stronger; the later ones are what is asked for.
    EXPECT_LT(TrippedAt(Sine(hz, 0.85 * least_n)), 0) << hz;
  }
}

TEST(SwingWatchTest, TripsWithinTheTimeOfItsHalfCyclesInAnyDirectionOfSpace) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 40; ++i) {
    const double hz = 12 + 2.0 * i;
    const dvec3 way(normal(random), normal(random), normal(random));
    const double at_s = TrippedAt(Sine(hz, 1.0, way / glm::length(way)));
    EXPECT_GT(at_s, 0) << hz;
    // Where force sets in, the first half cycles are uneven.
    EXPECT_LT(at_s, (SwingWatchParams{}.half_cycles + 2) / (2 * hz) + 2 * kTick_s) << hz;
  }
}

TEST(SwingWatchTest, TripsOnASwingThatTurnsInSpace) {
  EXPECT_GT(TrippedAt([](double t) {
              const double phase = 2 * M_PI * 20 * t;
              return dvec3(std::cos(phase), 0.6 * std::sin(phase), 0);
            }),
            0);
}

TEST(SwingWatchTest, NoHandsOwnMotionTripsIt) {
  EXPECT_LT(TrippedAt(Sine(4, 1.0), 10), 0);
  EXPECT_LT(TrippedAt(Sine(2, 5.0), 10), 0);
  EXPECT_LT(TrippedAt([](double t) { return dvec3(t < 0.5 ? 0 : 5, 0, 0); }), 0);
  EXPECT_LT(TrippedAt([](double t) { return dvec3(4 * t, -2 * t, 0); }), 0);
  // Taps: 4 N for 30 ms, five times a second.
  EXPECT_LT(TrippedAt(
                [](double t) {
                  const double in = std::fmod(t, 0.2);
                  return dvec3(0, 0, in < 0.03 ? 4 * std::sin(M_PI * in / 0.03) : 0);
                },
                5),
            0);
}

// Of a right profile in a light hand: b + d - Kc T/2 = 1.3 N s/m on .54 kg, 30 Hz, loses 8 % a cycle by
// damping and .36 N a cycle by friction. It starts at 3 N.
TEST(SwingWatchTest, ARingThatDiesAwayIsNoSwing) {
  for (double left : {0.80, 0.84, 0.90}) {
    EXPECT_LT(TrippedAt([&](double t) {
                const double cycles = 30 * t;
                return dvec3(0, 3 * std::pow(left, cycles) * std::sin(2 * M_PI * cycles), 0);
              }),
              0)
        << left;
  }
  EXPECT_GT(TrippedAt([](double t) {
              return dvec3(0, 3 * std::pow(0.97, 30 * t) * std::sin(2 * M_PI * 30 * t), 0);
            }),
            0);
}

TEST(SwingWatchTest, HalfCyclesFarApartAreNoSwing) {
  // Each a pulse of 10 ms, alternately to and fro.
  auto pulses = [](double apart_s) {
    return [=](double t) {
      const double in = std::fmod(t, apart_s);
      const double sign = static_cast<int>(t / apart_s) % 2 == 0 ? 1 : -1;
      return dvec3(in < 0.01 ? sign * 2 : 0, 0, 0);
    };
  };
  EXPECT_GT(TrippedAt(pulses(0.03)), 0);
  EXPECT_LT(TrippedAt(pulses(0.3), 5), 0);
}

TEST(SwingWatchTest, TheShareFallsInSmallStepsWhileItSwingsAndNoFurther) {
  SwingWatch watch({});
  double before = 1;
  for (int i = 0; i < 3000; ++i) {
    const double share = watch.Tick(Sine(25, 2)(i * kTick_s));
    EXPECT_LE(share, before);
    EXPECT_GE(share, before * (1 - SwingWatch::kFall_per_s * kTick_s) - 1e-12);
    before = share;
  }
  EXPECT_DOUBLE_EQ(before, SwingWatch::kMinShare);

  // One that ends a tenth of a second after it tripped.
  SwingWatch brief({});
  const double tripped_s = TrippedAt(Sine(25, 2));
  for (int i = 0; i < 3000; ++i) {
    const double t = i * kTick_s;
    brief.Tick(t < tripped_s + 0.1 ? Sine(25, 2)(t) : dvec3(0));
  }
  // Six half cycles of kFall at most: five to come, and one that is under way.
  EXPECT_GT(brief.share(), std::pow(SwingWatch::kFall, 7.5));
  EXPECT_LT(brief.share(), std::pow(SwingWatch::kFall, 3.5));
  brief.Forget();
  EXPECT_LT(brief.share(), 1);
  EXPECT_TRUE(brief.tripped());
}

TEST(SwingWatchTest, ForgettingStartsTheCountAgain) {
  SwingWatch watch({});
  for (int i = 0; i < 5000; ++i) {
    if (i % 60 == 0) watch.Forget();
    watch.Tick(Sine(30, 2)(i * kTick_s));
  }
  EXPECT_FALSE(watch.tripped());
}

TEST(SwingWatchTest, SavedAndRestoredItGoesOnTheSame) {
  SwingWatch whole({}), restored({});
  for (int i = 0; i < 110; ++i) whole.Tick(Sine(20, 1)(i * kTick_s));
  StateArchive save;
  whole.VisitState(save);
  const Bytes saved = save.Take();
  StateArchive load(saved);
  restored.VisitState(load);
  ASSERT_TRUE(load.Complete());
  for (int i = 110; i < 600; ++i) {
    const dvec3 force = Sine(20, 1)(i * kTick_s);
    ASSERT_EQ(whole.Tick(force), restored.Tick(force)) << i;
  }
  EXPECT_TRUE(restored.tripped());
}

TEST(SwingWatchTest, OtherLoopRatesSeeTheSameSwing) {
  for (double tick_s : {2e-3, 1e-3, 2.5e-4}) {
    const double at_s = TrippedAt(Sine(20, 1), 2, {.tick_s = tick_s});
    EXPECT_NEAR(at_s, 0.14, 0.02) << tick_s;
  }
}

}  // namespace
}  // namespace enamel::haptics
