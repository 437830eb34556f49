#include "station/lab/suites/joint_front.h"

#include <gtest/gtest.h>

#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

JointPoint Point(int32_t voxel_nm, double rate_hz, double us, double felt, bool proved = true) {
  JointPoint p;
  p.voxel_nm = voxel_nm;
  p.rate_hz = rate_hz;
  p.tick.mean_us = {us, 0.9 * us, 1.1 * us};
  p.tick.p99_us = {2 * us, 1.8 * us, 2.2 * us};
  p.felt_error = felt;
  p.proved = proved;
  p.runs = true;
  return p;
}

TEST(JointFrontTest, AnIntervalIsTheMedianBetweenTheSecondAndTheLastButOne) {
  const Interval i = IntervalOf({9, 1, 8, 2, 7, 3, 6, 4, 100});
  EXPECT_EQ(i.value, 6);
  EXPECT_EQ(i.low, 2);
  EXPECT_EQ(i.high, 9) << "one disturbed run does not move it";
  EXPECT_FALSE((Interval{0.1, -0.1, 0.3}).apart());
  EXPECT_TRUE((Interval{-0.2, -0.3, -0.1}).apart());
  const Interval sum = Interval{1, 0.7, 1.3} + Interval{2, 1.6, 2.4};
  EXPECT_NEAR(sum.value, 3, 1e-12);
  EXPECT_NEAR(sum.low, 2.5, 1e-12);
  EXPECT_NEAR(sum.high, 3.5, 1e-12);
}

// What runs slower as time passes slows all cases alike, because they take turns.
TEST(JointFrontTest, CasesTakeTurnsAndDifferencesArePaired) {
  std::vector<int> order;
  double slower = 0;
  auto Case = [&](int id, double us) {
    return TimedCase{[&, id, us] {
      order.push_back(id);
      slower += 10;
      return Spread{us + slower, 2 * (us + slower)};
    }};
  };
  const std::vector<Interval> more = MoreThanFirst_us({Case(0, 5), Case(1, 7)});
  ASSERT_EQ(order.size(), 2u * kRounds);
  for (size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], static_cast<int>(i % 2));
  EXPECT_NEAR(more[0].value, 0, 1e-9);
  EXPECT_NEAR(more[1].low, 12, 1e-9);
  EXPECT_NEAR(more[1].high, 12, 1e-9);
  const std::vector<TickTime> times = TimeInTurns({Case(0, 5)});
  EXPECT_NEAR(times[0].p99_us.value, 2 * times[0].mean_us.value, 1e-9);
}

TEST(JointFrontTest, OnlyTheProvedStandOnItAndTheDominatedDoNot) {
  std::vector<JointPoint> points = {
      Point(100'000, 1000, 5, 0.10),        // cheapest
      Point(50'000, 1000, 10, 0.08),        // better, dearer
      Point(50'000, 1000, 11, 0.09),        // worse and dearer than the one before
      Point(25'000, 1000, 20, 0.05, false)  // no proof
  };
  MarkJointFront(&points);
  EXPECT_TRUE(points[0].on_front);
  EXPECT_TRUE(points[1].on_front);
  EXPECT_FALSE(points[2].on_front);
  EXPECT_FALSE(points[3].on_front);
}

TEST(JointFrontTest, TheBestFitsWithItsSlowTicksAndItsOwnPeriod) {
  const std::vector<JointPoint> points = {
      Point(100'000, 1000, 5, 0.10), Point(50'000, 1000, 10, 0.08),
      Point(50'000, 4000, 150, 0.02),         // 330 us of p99, a period of 250
      Point(25'000, 1000, 20, 0.01, false)};  // no proof
  EXPECT_EQ(BestWithin(points, 1e6), &points[1]);
  EXPECT_EQ(BestWithin(points, 21.9), &points[0]) << "p99's upper end is 22";
  EXPECT_EQ(BestWithin(points, 1), nullptr);
}

TEST(JointFrontTest, OfErrorsThatAreTheSameTheCheapestIsPicked) {
  std::vector<JointPoint> points = {Point(100'000, 1000, 5, 0.0812),
                                    Point(50'000, 1000, 10, 0.0805), Point(25'000, 1000, 20, 0.08)};
  EXPECT_EQ(BestWithin(points, 200), &points[1]);
  points[0].felt_error = 0.0809;
  EXPECT_EQ(BestWithin(points, 200), &points[0]);
}

TEST(JointFrontTest, WhatTheDevicesLoopDoesNotCarryIsNotPicked) {
  std::vector<JointPoint> points = {Point(50'000, 1000, 10, 0.08), Point(50'000, 2000, 8, 0.06)};
  points[0].is_default = true;
  points[1].runs = false;
  EXPECT_EQ(BestWithin(points, 200), &points[0]);
  EXPECT_EQ(WhyBest(points, points[0], 200),
            "Voxels of 50 um, law lead-maxwell, 1000 Hz: of 1 combinations that have a proof, that "
            "the device's loop carries and whose slowest hundredth of ticks fits, the cheapest of "
            "those felt best, 8.00 % off. It is what is planned.");
  const std::string text = NextHalvings(points, points[0]);
  EXPECT_NE(text.find("2000 Hz, beyond this profile's loop, cost"), std::string::npos) << text;
  // A device's own rate, and what is slower with the same Kc.
  const DeviceModel omega = *ModelOf(ShippedProfiles()[0]);
  const JointAxes axes = FrontAxes(omega, {500, 4000}, {});
  ASSERT_EQ(axes.at_rates.size(), 3u);
  EXPECT_LE(axes.at_rates[0].kc_n_per_m, omega.kc_n_per_m);
  EXPECT_EQ(axes.at_rates[1].kc_n_per_m, omega.kc_n_per_m);
  EXPECT_GT(axes.at_rates[2].kc_n_per_m, omega.kc_n_per_m);
}

TEST(JointFrontTest, DifferencesWithinNoiseAreNotPrinted) {
  const std::vector<JointPoint> points = {Point(50'000, 1000, 10, 0.08),
                                          Point(25'000, 1000, 10.5, 0.075)};
  const std::string finer = NextHalvings(points, points[0]);
  EXPECT_NE(finer.find("25 um cost as much, within noise, and buy 0.50 points"), std::string::npos)
      << finer;
  const std::string coarser = NextHalvings(points, points[1]);
  EXPECT_NE(coarser.find("no finer voxel was measured; voxels of 50 um cost as much, within noise, "
                         "and lose 0.50 points"),
            std::string::npos)
      << coarser;
}

TEST(JointFrontTest, SaysWhatTheNextHalvingCostsAndBuys) {
  const std::vector<JointPoint> points = {
      Point(50'000, 1000, 10, 0.08), Point(25'000, 1000, 22, 0.075), Point(50'000, 2000, 8, 0.06)};
  EXPECT_EQ(NextHalvings(points, points[0]),
            "From voxels of 50 um at 1000 Hz, felt 8.0 % off: voxels of 25 um cost 12.0 us more a "
            "tick (22.0, 95 % 19.8 to 24.2) and buy 0.50 points of felt error; 2000 Hz cost 0.6 % "
            "more of "
            "a core and buy 2.00 points of felt error.");
  // What is worse is not sold as a gain of less than nothing.
  const std::vector<JointPoint> worse = {Point(50'000, 1000, 10, 0.08),
                                         Point(25'000, 1000, 22, 0.0800001),
                                         Point(50'000, 2000, 8, 0.09)};
  const std::string text = NextHalvings(worse, worse[0]);
  EXPECT_NE(text.find("buy less than 0.01 points"), std::string::npos) << text;
  EXPECT_NE(text.find("buy nothing: 1.00 more points"), std::string::npos) << text;
}

// A voxel that makes the force wrong is felt, and a proved law is marked as such.
TEST(JointFrontTest, AWrongVoxelIsFelt) {
  const DeviceModel omega = *ModelOf(ShippedProfiles()[0]);
  JointAxes axes;
  axes.at_rates = {omega};
  for (int32_t nm : {200'000, 50'000})
    axes.voxels.push_back({nm, nm == 200'000 ? 0.5 : 0.01, [nm](const DeviceModel&) {
                             return TimedCase{[nm] { return Spread{1e6 / nm, 2e6 / nm}; }};
                           }});
  axes.laws = {{haptics::LawKind::kLeadMaxwell}, {haptics::LawKind::kPaperLimited}};
  axes.ways_m = {WanderingMotion(0.2e-3, 4, 1).way_m};
  const std::vector<JointPoint> points = MeasureJointFront(axes);
  ASSERT_EQ(points.size(), 4u);
  EXPECT_TRUE(points[0].proved);
  EXPECT_FALSE(points[2].proved);
  EXPECT_GT(points[0].felt_error, points[1].felt_error + 0.05);
  EXPECT_FALSE(points[0].is_default);
  EXPECT_TRUE(points[1].is_default);
}

}  // namespace
}  // namespace enamel::station::lab
