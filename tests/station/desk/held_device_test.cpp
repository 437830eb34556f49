#include "station/desk/held_device.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace enamel::station::desk {
namespace {

class Handpiece final : public Device {
 public:
  std::string Name() const override { return "scripted"; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, Name(), "test"); }
  DeviceSample ReadSample() noexcept override {
    DeviceSample sample;
    sample.counts = {3, 4, 5};
    sample.orientation = orientation;
    sample.buttons = buttons;
    sample.bur_speed_krpm = 200;
    return sample;
  }
  void SendForce(const dvec3& force_n) noexcept override { sent_n = force_n; }
  void SendForceAndTorque(const dvec3& force_n, const dvec3& torque_n_m) noexcept override {
    sent_n = force_n;
    torque_sent_n_m = torque_n_m;
  }
  double still_before_force_s() const noexcept override { return 0.25; }
  dvec3 sent_n{0}, torque_sent_n_m{0};
  uint8_t buttons = kPedal | kFinish;
  QuantisedOrientation orientation = kIdentityOrientation;
};

TEST(HeldDeviceTest, WithTheSecondButtonHeldTheHandTurnsThePictureAndTheBurIsOff) {
  Handpiece inner;
  HeldDevice held(inner);
  EXPECT_FALSE(held.turns_view());
  inner.buttons = kPedal | kSecond;
  const DeviceSample sample = held.ReadSample();
  EXPECT_TRUE(held.turns_view());
  EXPECT_EQ(sample.buttons & kPedal, 0);
  EXPECT_EQ(sample.bur_speed_krpm, 0);
  EXPECT_EQ(sample.counts[2], 5) << "the recording has where the hand was";
  inner.buttons = kPedal;
  EXPECT_EQ(held.ReadSample().buttons, kPedal);
  EXPECT_FALSE(held.turns_view());
}

TEST(HeldDeviceTest, PausedTheBurStandsStillAndEverythingElseGoesOn) {
  Handpiece inner;
  HeldDevice held(inner);
  EXPECT_EQ(held.ReadSample().buttons, kPedal | kFinish);
  EXPECT_EQ(held.speed_krpm(), 200);
  held.SetPaused(true);
  DeviceSample paused = held.ReadSample();
  EXPECT_EQ(paused.buttons, kFinish);
  EXPECT_EQ(paused.bur_speed_krpm, 0);
  EXPECT_EQ(paused.counts[2], 5);
  EXPECT_EQ(held.speed_krpm(), 0);
  held.SendForce({1, 2, 3});
  EXPECT_EQ(inner.sent_n.y, 2);
  held.SendForceAndTorque({1, 2, 3}, {4, 5, 6});
  EXPECT_EQ(inner.torque_sent_n_m, dvec3(4, 5, 6));
  held.SetPaused(false);
  EXPECT_EQ(held.ReadSample().buttons, kPedal | kFinish);
}

TEST(HeldDeviceTest, TurnedItsAxesAndItsForcesTurnTogether) {
  for (int quarters = 1; quarters < 4; ++quarters) {
    Handpiece inner;
    inner.buttons = 0;
    // The bur points along the device's x.
    inner.orientation = ToQuantised({0, std::sqrt(0.5), 0, std::sqrt(0.5)});
    HeldDevice held(inner);
    const DeviceSample before = held.ReadSample();
    held.SetQuarters(quarters);
    const DeviceSample turned = held.ReadSample();
    EXPECT_TRUE(turned.turned);
    EXPECT_FALSE(held.ReadSample().turned) << "once";
    const double angle = quarters * std::numbers::pi / 2, c = std::cos(angle), s = std::sin(angle);
    EXPECT_EQ(turned.counts[0], std::lround(c * before.counts[0] - s * before.counts[1]));
    EXPECT_EQ(turned.counts[1], std::lround(s * before.counts[0] + c * before.counts[1]));
    EXPECT_EQ(turned.counts[2], before.counts[2]);
    EXPECT_EQ(held.own_counts(), before.counts);
    const dvec3 along = FromQuantised(turned.orientation).Matrix()[2];
    EXPECT_NEAR(along.x, c, 1e-4);
    EXPECT_NEAR(along.y, s, 1e-4);
    // What the scene pushes along the bur comes out along the device's x.
    held.SendForce(dvec3(c, s, 0.5));
    EXPECT_LT(glm::length(inner.sent_n - dvec3(1, 0, 0.5)), 1e-12);
  }
}

TEST(HeldDeviceTest, TheBurIsOffBeforeTheAxesTurn) {
  Handpiece inner;
  HeldDevice held(inner);
  held.ReadSample();
  held.SetQuarters(1);
  EXPECT_EQ(held.ReadSample().counts[0], 3);
  inner.buttons = 0;
  EXPECT_EQ(held.ReadSample().counts[0], -4);
  inner.buttons = kPedal;
  const DeviceSample later = held.ReadSample();
  EXPECT_EQ(later.counts[0], -4);
  EXPECT_FALSE(later.turned);
}

TEST(HeldDeviceTest, TurnedBeforeItsFirstSampleItHasNotJumped) {
  Handpiece inner;
  inner.buttons = 0;
  HeldDevice held(inner);
  held.SetQuarters(2);
  const DeviceSample first = held.ReadSample();
  EXPECT_EQ(first.counts[0], -3);
  EXPECT_FALSE(first.turned);
}

TEST(HeldDeviceTest, AsksForTheSameRestAsTheDeviceInside) {
  Handpiece inner;
  EXPECT_EQ(HeldDevice(inner).still_before_force_s(), 0.25);
}

}  // namespace
}  // namespace enamel::station::desk
