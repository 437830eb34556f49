#include "station/devices/pointer_device.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/allocation_guard.h"

namespace enamel::station {
namespace {

constexpr double kDelta = 5e-6, kTick = 1e-3;

void ExpectNear(const dvec3& a, const dvec3& b, double tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "axis " << i;
}

// The shank's direction in the scene: the bur's +z.
dvec3 Shank(const PointerMapping& m) { return m.pose().orientation.Matrix() * dvec3(0, 0, 1); }

DeviceSample After(PointerDevice& device, int ticks) {
  DeviceSample s;
  for (int i = 0; i < ticks; ++i) s = device.ReadSample();
  return s;
}

TEST(PointerMappingTest, MouseMovesInTheOcclusalPlaneAndTheWheelIsDepthSeenFromAbove) {
  PointerMapping m;
  m.SetView({1, 0, 0}, {0, -0.3, 0.95}, 10e-6);
  m.MoveBy(100, 0);
  ExpectNear(m.pose().offset_m, {1e-3, 0, 0}, 1e-12);
  m.MoveBy(0, -50);  // up on the screen
  ExpectNear(m.pose().offset_m, {1e-3, 0.5e-3, 0}, 1e-12);
  m.Wheel(3);
  ExpectNear(m.pose().offset_m, {1e-3, 0.5e-3, -0.3e-3}, 1e-12);
}

TEST(PointerMappingTest, SeenFromTheSideTheWheelGoesIntoThatSide) {
  PointerMapping m;
  m.SetView({1, 0, 0}, {0, -1, 0.2}, 10e-6);
  m.MoveBy(0, 100);  // down on the screen
  ExpectNear(m.pose().offset_m, {0, 0, -1e-3}, 1e-12);
  m.Wheel(1);
  ExpectNear(m.pose().offset_m, {0, 0.1e-3, -1e-3}, 1e-12);
}

TEST(PointerMappingTest, FineKeyScalesAllMotion) {
  PointerMapping m;
  m.SetView({1, 0, 0}, {0, 0, 1}, 10e-6);
  m.SetFine(true);
  m.MoveBy(100, 0);
  m.Wheel(1);
  ExpectNear(m.pose().offset_m, {0.2e-3, 0, -0.02e-3}, 1e-12);
}

TEST(PointerMappingTest, NeverLeavesItsReachNorTakesWhatIsNotFinite) {
  PointerMapping m({0.01});
  for (int i = 0; i < 1000; ++i) m.MoveBy(997, -313);
  EXPECT_LE(glm::length(m.pose().offset_m), 0.01 + 1e-12);
  dvec3 before = m.pose().offset_m;
  m.MoveBy(std::numeric_limits<double>::quiet_NaN(), 0);
  m.Wheel(std::numeric_limits<double>::infinity());
  m.SetView({0, 0, 0}, {0, 0, 1}, 1);
  m.SetView({1, 0, 0}, {0, 0, 1}, -1);
  ExpectNear(m.pose().offset_m, before, 0);
}

TEST(PointerMappingTest, TiltKeysLeanTheShankRightAndAwayAtTheirRateUpToTheLimit) {
  PointerMapping m;
  m.SetView({1, 0, 0}, {0, 0, 1}, 10e-6);
  m.SetTilt(1, 0);
  for (int i = 0; i < 10; ++i) m.Advance(0.05);  // 0.4 rad
  ExpectNear(Shank(m), {std::sin(0.4), 0, std::cos(0.4)}, 1e-9);
  m.Straighten();
  m.SetTilt(0, 1);
  for (int i = 0; i < 100; ++i) m.Advance(0.05);
  ExpectNear(Shank(m), {0, std::sin(1.05), std::cos(1.05)}, 1e-9);
  m.Advance(-1);
  m.SetTilt(0, -1);
  m.Advance(1e9);  // a window that hung: a tenth of a second
  ExpectNear(Shank(m), {0, std::sin(0.97), std::cos(0.97)}, 1e-9);
}

TEST(PointerMappingTest, LosingTheFocusReleasesThePedalAndTheTilt) {
  PointerMapping m;
  m.SetPedal(true);
  m.SetTilt(1, 1);
  EXPECT_EQ(m.pose().buttons, kPedal);
  m.ReleaseKeys();
  m.Advance(0.1);
  EXPECT_EQ(m.pose().buttons, 0);
  ExpectNear(Shank(m), {0, 0, 1}, 1e-12);
}

TEST(PointerMappingTest, TheBurIsCalledBackToItsStartUnlessItIsCutting) {
  PointerSettings settings;
  settings.start_m = {0, 0, -0.006};
  PointerMapping mapping(settings);
  EXPECT_EQ(mapping.pose().offset_m, settings.start_m);
  mapping.MoveBy(500, -300);
  mapping.SetTilt(1, 0);
  mapping.Advance(0.1);
  mapping.SetPedal(true);
  const dvec3 cutting = mapping.pose().offset_m;
  mapping.Recall();
  EXPECT_EQ(mapping.pose().offset_m, cutting);
  mapping.SetPedal(false);
  mapping.SetTilt(0, 0);
  mapping.Recall();
  EXPECT_EQ(mapping.pose().offset_m, settings.start_m);
  EXPECT_EQ(mapping.pose().orientation.w, 1);
}

TEST(PointerDeviceTest, BeginsAtItsStart) {
  PointerDevice device(1e-6, 1e-3, {0, 0.001, -0.006});
  for (int i = 0; i < 100; ++i) {
    const DeviceSample sample = device.ReadSample();
    EXPECT_EQ(sample.counts, (std::array<int32_t, 3>{0, 1000, -6000}));
  }
}

TEST(PointerDeviceTest, StaysAtTheCentreUntilSomethingIsPublished) {
  PointerDevice device(kDelta, kTick);
  DeviceSample s = After(device, 100);
  EXPECT_EQ(s.counts, (std::array<int32_t, 3>{0, 0, 0}));
  EXPECT_EQ(s.orientation, kIdentityOrientation);
  EXPECT_EQ(s.buttons, 0);
  EXPECT_TRUE(s.fresh);
  EXPECT_FALSE(device.has_motors());
}

TEST(PointerDeviceTest, FollowsASmallStepAsTwoFirstOrderFilters) {
  PointerDevice device(1e-9, kTick);
  PointerPose pose;
  pose.offset_m = {0.3e-3, -0.3e-3, 0};
  device.Publish(pose);
  for (int tick = 1; tick <= 80; ++tick) {
    DeviceSample s = device.ReadSample();
    // Exact for this recursion: 1 - r^n - n (1 - r) r^n, r = lag / (lag + T).
    double r = PointerDevice::kLag_s / (PointerDevice::kLag_s + kTick), rn = std::pow(r, tick);
    double expected = 0.3e-3 * (1 - rn - tick * (1 - r) * rn);
    ASSERT_NEAR(s.counts[0] * 1e-9, expected, 1e-9) << tick;
    ASSERT_EQ(s.counts[1], -s.counts[0]);
  }
}

TEST(PointerDeviceTest, AJumpOfThePointerIsAMotionOfBoundedSpeed) {
  PointerDevice device(kDelta, kTick);
  PointerPose pose;
  pose.offset_m = {0.02, 0, -0.01};
  device.Publish(pose);
  double limit = PointerDevice::kMaxSpeed_m_per_s * kTick / kDelta;
  std::array<int32_t, 3> before{};
  for (int tick = 0; tick < 600; ++tick) {
    DeviceSample s = device.ReadSample();
    double dx = s.counts[0] - before[0], dz = s.counts[2] - before[2];
    ASSERT_LE(std::sqrt(dx * dx + dz * dz), limit + 1.5);
    before = s.counts;
  }
  EXPECT_NEAR(before[0], 4000, 1);
  EXPECT_NEAR(before[2], -2000, 1);
}

TEST(PointerDeviceTest, PedalIsReleasedWhenTheWindowHangs) {
  PointerDevice device(kDelta, kTick);
  PointerPose pose;
  pose.buttons = kPedal;
  device.Publish(pose);
  EXPECT_EQ(After(device, 490).buttons, kPedal);
  EXPECT_EQ(After(device, 1).bur_speed_krpm, kTurbineSpeed_krpm);
  EXPECT_EQ(After(device, 20).buttons, 0);
  device.Publish(pose);
  EXPECT_EQ(After(device, 1).buttons, kPedal);
}

TEST(PointerDeviceTest, AllocatesNothingInATick) {
  PointerDevice device(kDelta, kTick);
  testing_support::AllocationGuard guard;
  for (int i = 0; i < 100; ++i) {
    device.Publish({{1e-3 * i, 0, 0}, {}, kPedal});
    device.ReadSample();
    device.SendForce(dvec3(1));
  }
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace enamel::station
