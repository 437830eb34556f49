#include "station/desk/held_device.h"

#include <gtest/gtest.h>

namespace enamel::station::desk {
namespace {

class Handpiece final : public Device {
 public:
  std::string Name() const override { return "scripted"; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, Name(), "test"); }
  DeviceSample ReadSample() noexcept override {
    DeviceSample sample;
    sample.counts = {3, 4, 5};
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

TEST(HeldDeviceTest, AsksForTheSameRestAsTheDeviceInside) {
  Handpiece inner;
  EXPECT_EQ(HeldDevice(inner).still_before_force_s(), 0.25);
}

}  // namespace
}  // namespace enamel::station::desk
