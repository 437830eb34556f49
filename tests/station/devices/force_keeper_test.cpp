#include "station/devices/force_keeper.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace enamel::station {
namespace {

constexpr int kWatchdog_ms = 20;

TEST(ForceKeeperTest, SendsEachNewForceOnce) {
  ForceKeeper keeper(kWatchdog_ms);
  keeper.Take(dvec3(1, 2, 3), 1, 1000);
  auto c = keeper.Next(1000);
  ASSERT_TRUE(c);
  EXPECT_EQ(c->force_n, dvec3(1, 2, 3));
  EXPECT_TRUE(c->motors_on);
  keeper.Take(dvec3(1, 2, 3), 1, 1500);  // the same one
  EXPECT_FALSE(keeper.Next(1500));
  keeper.Take(dvec3(0, 0, 1), 2, 2000);
  EXPECT_EQ(keeper.WaitFor_us(2000), 0);
  EXPECT_EQ(keeper.Next(2000)->force_n, dvec3(0, 0, 1));
  EXPECT_EQ(keeper.WaitFor_us(2000), 5000);
}

TEST(ForceKeeperTest, FeedsTheWatchdogFourTimesPerItsTimeForEver) {
  ForceKeeper keeper(kWatchdog_ms);
  keeper.Take(dvec3(1, 0, 0), 1, 0);
  int64_t last = 0, longest = 0;
  int sent = 0;
  for (int64_t t = 0; t < 1'000'000; t += 100) {
    if (!keeper.Next(t)) continue;
    longest = std::max(longest, t - last);
    last = t;
    ++sent;
  }
  EXPECT_EQ(longest, kWatchdog_ms * 250);
  EXPECT_EQ(sent, 200);
}

TEST(ForceKeeperTest, NeverKeepsAnOldForceAlive) {
  ForceKeeper keeper(4);  // repeats each millisecond
  keeper.Take(dvec3(0, 0, 2), 1, 0);
  for (int64_t t = 0; t <= 100'000; t += 1000) {
    auto c = keeper.Next(t);
    ASSERT_TRUE(c) << t;
    // Held for 5 ms, then linear to 0 at 20 ms.
    double share = t <= 5'000 ? 1 : t >= 20'000 ? 0 : (20'000 - static_cast<double>(t)) / 15'000;
    EXPECT_NEAR(c->force_n.z, 2 * share, 1e-12) << t;
    EXPECT_EQ(c->motors_on, t < 20'000) << t;
  }
  keeper.Take(dvec3(0, 0, 1), 2, 200'000);
  EXPECT_EQ(keeper.Next(200'000)->force_n.z, 1);
}

TEST(ForceKeeperTest,
     ForceIsGoneAtTwentyMillisecondsHoweverLongTheWatchdogIsAndHoweverLateItWakes) {
  for (int watchdog_ms : {1, 4, 20, 27, 100, 1000}) {
    for (int64_t wakes_late_us : {0, 70, 900}) {
      ForceKeeper keeper(watchdog_ms);
      keeper.Take(dvec3(0, 0, 2), 1, 0);
      int64_t t = 0;
      double held = 0;
      while (t <= ForceKeeper::kGone_us + wakes_late_us) {
        if (auto c = keeper.Next(t)) held = c->force_n.z;
        int64_t wait = keeper.WaitFor_us(t);
        if (t < ForceKeeper::kGone_us) {
          EXPECT_LE(wait, ForceKeeper::kHold_us) << t;
        }
        t += std::max<int64_t>(wait, 1) + wakes_late_us;
        if (t > 2 * (ForceKeeper::kHold_us + wakes_late_us)) {
          EXPECT_LT(held, 2) << "not falling at " << t << ", watchdog " << watchdog_ms;
        }
      }
      EXPECT_EQ(held, 0) << "watchdog " << watchdog_ms << ", late " << wakes_late_us;
    }
  }
}

TEST(ForceKeeperTest, MotorsAreOffBeforeTheFirstForce) {
  ForceKeeper keeper(kWatchdog_ms);
  keeper.Take(dvec3(5, 5, 5), 0, 4'000);
  auto c = keeper.Next(6'000);
  ASSERT_TRUE(c);
  EXPECT_EQ(c->force_n, dvec3(0));
  EXPECT_FALSE(c->motors_on);
}

TEST(ForceKeeperTest, TorqueGoesAndFallsWithItsForce) {
  ForceKeeper keeper(4);
  keeper.Take(dvec3(0, 0, 2), 1, 0, dvec3(0.1, 0, 0));
  auto c = keeper.Next(0);
  ASSERT_TRUE(c);
  EXPECT_EQ(c->torque_n_m, dvec3(0.1, 0, 0));
  const int64_t half = (ForceKeeper::kHold_us + ForceKeeper::kGone_us) / 2;
  c = keeper.Next(half);
  ASSERT_TRUE(c);
  EXPECT_NEAR(c->force_n.z, 1, 1e-3);
  EXPECT_NEAR(c->torque_n_m.x, 0.05, 1e-4);
  c = keeper.Next(ForceKeeper::kGone_us);
  ASSERT_TRUE(c);
  EXPECT_EQ(c->torque_n_m, dvec3(0));
  keeper.Take(dvec3(0, 0, 1), 2, 30'000);
  EXPECT_EQ(keeper.Next(30'000)->torque_n_m, dvec3(0)) << "a force without torque takes it away";
  keeper.Take(dvec3(0, 0, 1), 3, 31'000, dvec3(0, std::numeric_limits<double>::infinity(), 0));
  c = keeper.Next(31'000);
  EXPECT_EQ(c->force_n, dvec3(0));
  EXPECT_EQ(c->torque_n_m, dvec3(0));
}

TEST(ForceKeeperTest, WhatIsNotFiniteIsZero) {
  for (double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    ForceKeeper keeper(kWatchdog_ms);
    keeper.Take(dvec3(1, bad, 0), 1, 0);
    EXPECT_EQ(keeper.Next(0)->force_n, dvec3(0));
  }
}

}  // namespace
}  // namespace enamel::station
