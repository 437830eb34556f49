#include "station/hid/space_mouse.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "tests/station/hid/hid_double.h"

namespace enamel::station::hid {
namespace {

using testing_support::HidBus;
using testing_support::ScriptedHid;

constexpr double kDelta = 1e-6, kTick = 1e-3;

TEST(SpaceMouseReportTest, SeparateReportsFillOneHalfEach) {
  SpaceMouseState s;
  // As recorded from a SpaceNavigator: a turn of -30 about the second axis.
  const uint8_t rotation[] = {0x02, 0x00, 0x00, 0xe2, 0xff, 0x00, 0x00};
  const uint8_t translation[] = {0x01, 0x5e, 0x01, 0xa2, 0xfe, 0x07, 0x00};
  EXPECT_EQ(TakeReport(rotation, s), SpaceMouseReport::kTaken);
  EXPECT_EQ(s.axes, (std::array<int16_t, 6>{0, 0, 0, 0, -30, 0}));
  EXPECT_EQ(TakeReport(translation, s), SpaceMouseReport::kTaken);
  EXPECT_EQ(s.axes, (std::array<int16_t, 6>{350, -350, 7, 0, -30, 0}));
}

TEST(SpaceMouseReportTest, CombinedReportFillsBoth) {
  SpaceMouseState s;
  const uint8_t both[] = {0x01, 1, 0, 2, 0, 3, 0, 0xff, 0xff, 0xfe, 0xff, 0xfd, 0xff};
  EXPECT_EQ(TakeReport(both, s), SpaceMouseReport::kTaken);
  EXPECT_EQ(s.axes, (std::array<int16_t, 6>{1, 2, 3, -1, -2, -3}));
}

TEST(SpaceMouseReportTest, ButtonsAreBitsLowestFirst) {
  SpaceMouseState s;
  const uint8_t both[] = {0x03, 0x03}, many[] = {0x03, 0x00, 0x80, 0x01, 0x00}, none[] = {0x03, 0};
  EXPECT_EQ(TakeReport(both, s), SpaceMouseReport::kTaken);
  EXPECT_EQ(s.buttons, 3u);
  EXPECT_EQ(TakeReport(many, s), SpaceMouseReport::kTaken);
  EXPECT_EQ(s.buttons, 0x18000u);
  EXPECT_EQ(TakeReport(none, s), SpaceMouseReport::kTaken);
  EXPECT_EQ(s.buttons, 0u);
}

TEST(SpaceMouseReportTest, ShortAndOtherReportsChangeNothing) {
  const uint8_t all[] = {0x01, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9};
  for (uint8_t id : {uint8_t{1}, uint8_t{2}, uint8_t{3}}) {
    for (size_t n = 0; n < (id == 3 ? 2u : 7u); ++n) {
      Bytes report(all, all + n);
      if (n > 0) report[0] = id;
      SpaceMouseState s;
      EXPECT_EQ(TakeReport(report, s), SpaceMouseReport::kTooShort) << int{id} << " " << n;
      EXPECT_EQ(s, SpaceMouseState{});
    }
  }
  const uint8_t battery[] = {0x17, 100, 1};
  SpaceMouseState s;
  EXPECT_EQ(TakeReport(battery, s), SpaceMouseReport::kIgnored);
  // Between the two families: translation only.
  EXPECT_EQ(TakeReport({all, 12}, s), SpaceMouseReport::kTaken);
  EXPECT_EQ(s.axes[3], 0);
}

TEST(SpaceMouseMotionTest, PushingGoesWhereTheHandPushes) {
  SpaceMouseSettings settings;
  SpaceMouseState s;
  s.axes = {350, -350, -350, 0, 0, 0};  // right, away from the user, up
  dvec3 v = MotionOf(s, settings).velocity_m_per_s;
  for (int i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(v[i], settings.max_speed_m_per_s);
  s.axes = {10, -10, 3, 9, -9, 10};  // the dead zone
  EXPECT_EQ(MotionOf(s, settings).velocity_m_per_s, dvec3(0));
  EXPECT_EQ(MotionOf(s, settings).turn_rad_per_s, dvec3(0));
  s.axes = {180, 32767, -32768, 0, 0, 180};  // half way: a quarter; more than full: full
  SpaceMouseMotion m = MotionOf(s, settings);
  EXPECT_DOUBLE_EQ(m.velocity_m_per_s.x, settings.max_speed_m_per_s / 4);
  EXPECT_DOUBLE_EQ(m.velocity_m_per_s.y, -settings.max_speed_m_per_s);
  EXPECT_DOUBLE_EQ(m.velocity_m_per_s.z, settings.max_speed_m_per_s);
  // Clockwise seen from above is positive about its z, which is down: negative about ours.
  EXPECT_DOUBLE_EQ(m.turn_rad_per_s.z, -settings.max_turn_rad_per_s / 4);
}

ScriptedHid Wireless() {
  ScriptedHid d;
  d.path = "/dev/hidraw2";
  d.vendor = 0x256f;
  d.product = 0xc62e;
  d.usage_page = kMultiAxisPage;
  d.usage = kMultiAxisUsage;
  d.name = L"SpaceMouse Wireless";
  return d;
}

class SpaceMouseTest : public testing::Test {
 protected:
  SpaceMouseTest() {
    bus_.Reset();
    bus_.Plug(Wireless());
    auto mouse = SpaceMouse::Open({}, kDelta, kTick);
    EXPECT_TRUE(mouse.ok()) << mouse.status().message();
    mouse_ = std::move(*mouse);
    EXPECT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 1; }));
  }
  ~SpaceMouseTest() override {
    mouse_.reset();
    bus_.Reset();
  }
  void Send(const Bytes& report) {
    uint64_t before = mouse_->counters().samples;
    bus_.Send(Wireless().path, report);
    for (int i = 0; i < 10'000 && mouse_->counters().samples == before; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_EQ(mouse_->counters().samples, before + 1);
  }
  DeviceSample Ticks(int n) {
    DeviceSample s;
    for (int i = 0; i < n; ++i) s = mouse_->ReadSample();
    return s;
  }

  HidBus& bus_ = HidBus::Get();
  std::unique_ptr<SpaceMouse> mouse_;
};

TEST_F(SpaceMouseTest, DeflectionIsSpeedUntilItIsLetGo) {
  Send({1, 0x5e, 0x01, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});  // full right: 20 mm/s
  EXPECT_NEAR(Ticks(100).counts[0], 2000, 1);
  Send({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_NEAR(Ticks(100).counts[0], 2000, 1);
  EXPECT_TRUE(Ticks(1).attached);
  EXPECT_TRUE(Ticks(1).fresh);
}

TEST_F(SpaceMouseTest, SilenceWhileDeflectedCountsAsLetGo) {
  Send({1, 0x5e, 0x01, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  int32_t there = Ticks(251).counts[0];
  EXPECT_NEAR(there, 5020, 25);
  EXPECT_EQ(Ticks(1000).counts[0], there);
}

TEST_F(SpaceMouseTest, TurnsAtItsRateAndStaysAUnitQuaternion) {
  Send({2, 0, 0, 0, 0, 0xa2, 0xfe});  // full anticlockwise from above: 1 rad/s about +z
  DeviceSample s = Ticks(200);
  Quat q = FromQuantised(s.orientation);
  EXPECT_NEAR(2 * std::atan2(q.z, q.w), 0.2, 1e-3);
  EXPECT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1, 1e-9);
}

TEST_F(SpaceMouseTest, StaysWithinItsReach) {
  for (int i = 0; i < 20; ++i) {
    Send({1, 0x5e, 0x01, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    Ticks(200);
  }
  EXPECT_NEAR(Ticks(1).counts[0], 30'000, 1);
}

TEST_F(SpaceMouseTest, UnpluggedWhileDeflectedStopsWithThePedalUp) {
  Send({3, 2});
  EXPECT_EQ(Ticks(1).buttons, kSecond);
  Send({3, 1});
  EXPECT_EQ(Ticks(1).buttons, kPedal);
  Send({1, 0x5e, 0x01, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  bus_.Unplug(Wireless().path);
  for (int i = 0; i < 10'000 && mouse_->counters().detached == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  // The thread counts first and publishes next.
  DeviceSample s = Ticks(1);
  for (int i = 0; i < 10'000 && s.attached; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    s = Ticks(1);
  }
  EXPECT_FALSE(s.attached);
  EXPECT_EQ(s.buttons, 0);
  EXPECT_EQ(Ticks(100).counts, s.counts);
}

}  // namespace
}  // namespace enamel::station::hid
