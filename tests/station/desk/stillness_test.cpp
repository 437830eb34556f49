#include "station/desk/watch/stillness.h"

#include <gtest/gtest.h>

namespace enamel::station::desk {
namespace {

constexpr double kResolution_m = 10e-6;
// 0.5 mm is 50 counts.
DeviceSample At(int32_t x, uint8_t buttons = 0, bool attached = true) {
  DeviceSample sample;
  sample.counts = {x, 0, 0};
  sample.buttons = buttons;
  sample.attached = attached;
  return sample;
}

TEST(StillnessTest, PassesOnceTheHandpieceHasRestedLongEnough) {
  StillnessCheck check(kResolution_m);
  check.Look(At(0), 0);
  check.Look(At(40), 0.35);
  EXPECT_FALSE(check.passed());
  EXPECT_NEAR(check.share(), 0.5, 1e-9);
  check.Look(At(-40), StillnessCheck::kWanted_s);
  EXPECT_TRUE(check.passed());
  EXPECT_EQ(check.wanted(), "");
}

TEST(StillnessTest, MotionBeyondHalfAMillimetreBeginsAnewAndSaysSo) {
  StillnessCheck check(kResolution_m);
  check.Look(At(0), 0);
  check.Look(At(51), 0.6);
  EXPECT_EQ(check.wanted(), "ready.hold_still");
  check.Look(At(51), 0.8);
  EXPECT_FALSE(check.passed());
  check.Look(At(51), 1.4);
  EXPECT_TRUE(check.passed());
}

TEST(StillnessTest, APedalThatIsDownOrADeviceThatIsNotThereNeverPasses) {
  StillnessCheck pedal(kResolution_m), gone(kResolution_m);
  for (double t = 0; t < 5; t += 0.1) {
    pedal.Look(At(0, kPedal), t);
    gone.Look(At(0, 0, false), t);
  }
  EXPECT_FALSE(pedal.passed());
  EXPECT_EQ(pedal.wanted(), "ready.foot_off");
  EXPECT_FALSE(gone.passed());
  EXPECT_EQ(gone.wanted(), "ready.plug_in");
}

TEST(StillnessTest, AHandpieceInItsHolderIsToBeTakenUpFirst) {
  StillnessCheck check(kResolution_m);
  for (double t = 0; t < 5; t += 0.1) check.Look(At(0, kPutDown), t);
  EXPECT_FALSE(check.passed());
  EXPECT_EQ(check.wanted(), "ready.take_up");
  check.Look(At(0), 5.2);
  check.Look(At(0), 5.8);
  EXPECT_TRUE(check.passed());
}

TEST(StillnessTest, NothingSeenIsNotStill) { EXPECT_FALSE(StillnessCheck(1e-5).passed()); }

}  // namespace
}  // namespace enamel::station::desk
