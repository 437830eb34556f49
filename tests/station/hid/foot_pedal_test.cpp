#include "station/hid/foot_pedal.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <thread>

#include "station/devices/pointer_device.h"
#include "tests/station/hid/hid_double.h"
#include "tests/support/opens_with.h"

namespace enamel::station::hid {
namespace {

using testing_support::HidBus;
using testing_support::ScriptedHid;

ScriptedHid Vec() {
  ScriptedHid d;
  d.path = "/dev/hidraw7";
  d.vendor = 0x05f3;
  d.product = 0x00ff;
  d.name = L"VEC USB Footpedal";
  return d;
}

class FootPedalTest : public testing::Test {
 protected:
  FootPedalTest() { bus_.Reset(); }
  ~FootPedalTest() override { bus_.Reset(); }

  // Waits until the pedal's thread has seen it, at most ten seconds.
  static bool Becomes(const FootPedal& pedal, uint8_t buttons) {
    for (int i = 0; i < 10'000 && pedal.buttons() != buttons; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return pedal.buttons() == buttons;
  }
  std::unique_ptr<FootPedal> Open(const PedalSettings& settings) {
    auto pedal = FootPedal::Open(settings);
    EXPECT_TRUE(pedal.ok()) << pedal.status().message();
    EXPECT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 1; }));
    return std::move(*pedal);
  }

  HidBus& bus_ = HidBus::Get();
};

TEST(ReadPedalTest, AnyOfTheThreePedalsOfTheVecIsThePedal) {
  PedalSettings vec;
  for (uint8_t byte = 0; byte < 16; ++byte) {
    const uint8_t report[] = {byte, 0};
    PedalReading r = ReadPedal(vec, report);
    EXPECT_TRUE(r.relevant);
    EXPECT_EQ(r.down, (byte & 7) != 0) << int{byte};
  }
  EXPECT_FALSE(ReadPedal(vec, {}).relevant);
}

TEST(ReadPedalTest, GenericPedalIsWhereItsSettingsSay) {
  auto settings = ParsePedal("1a86:e026,id=3,byte=2,mask=40");
  ASSERT_TRUE(settings.ok());
  EXPECT_EQ(settings->match.vendor, 0x1a86);
  EXPECT_EQ(settings->match.product, 0xe026);
  const uint8_t down[] = {3, 0, 0x40}, up[] = {3, 0xff, 0xbf}, other[] = {4, 0, 0x40},
                cut[] = {3, 0};
  EXPECT_TRUE(ReadPedal(*settings, down).down);
  EXPECT_FALSE(ReadPedal(*settings, up).down);
  EXPECT_FALSE(ReadPedal(*settings, other).relevant);
  EXPECT_FALSE(ReadPedal(*settings, cut).relevant);
}

TEST(ReadPedalTest, SettingsThatCannotBeMeantAreRefusedWithWhatWasExpected) {
  for (const char* text :
       {"", "05f3", "05f3:", ":00ff", "xyzw:00ff", "105f3:00ff", "05f3:00ff,", "05f3:00ff,mask=0",
        "05f3:00ff,mask=100", "05f3:00ff,byte=", "05f3:00ff,foo=1"}) {
    auto settings = ParsePedal(text);
    ASSERT_FALSE(settings.ok()) << text;
    EXPECT_NE(settings.status().message().find("expected"), std::string::npos) << text;
  }
  EXPECT_EQ(ParsePedal("05f3:00ff:A1")->match.serial, "A1");
}

TEST_F(FootPedalTest, FollowsThePedalByteByByte) {
  bus_.Plug(Vec());
  auto pedal = Open({});
  EXPECT_EQ(pedal->Name(), "VEC USB Footpedal");
  EXPECT_EQ(pedal->buttons(), 0);
  const uint8_t down[] = {0x02, 0x00}, up[] = {0x00, 0x00};
  bus_.Send(Vec().path, down);
  EXPECT_TRUE(Becomes(*pedal, kPedal));
  bus_.Send(Vec().path, up);
  EXPECT_TRUE(Becomes(*pedal, 0));
}

TEST_F(FootPedalTest, UnpluggedWhileDownIsReleasedAndComesBackByItself) {
  bus_.Plug(Vec());
  auto pedal = Open({});
  const uint8_t down[] = {0x01, 0x00};
  bus_.Send(Vec().path, down);
  ASSERT_TRUE(Becomes(*pedal, kPedal));
  bus_.Unplug(Vec().path);
  EXPECT_TRUE(Becomes(*pedal, 0));
  ScriptedHid elsewhere = Vec();
  elsewhere.path = "/dev/hidraw9";
  ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 0; }));
  bus_.Plug(elsewhere);
  ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 1; }));
  EXPECT_EQ(pedal->buttons(), 0);
  bus_.Send(elsewhere.path, down);
  EXPECT_TRUE(Becomes(*pedal, kPedal));
}

TEST_F(FootPedalTest, MissingAndForbiddenPedalsSayWhatToDo) {
  auto missing = FootPedal::Open({});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.status().code(), Code::kNotFound);
  EXPECT_NE(missing.status().message().find("05f3:00ff"), std::string::npos);
  ScriptedHid locked = Vec();
  locked.may_open = false;
  bus_.Plug(locked);
  const test::OpensWith call([](const char*, int) {
    errno = EACCES;
    return -1;
  });
  auto forbidden = FootPedal::Open({});
  ASSERT_FALSE(forbidden.ok());
  EXPECT_NE(forbidden.status().message().find("60-enamel.rules"), std::string::npos);
}

TEST_F(FootPedalTest, GivesADeviceWithoutAPedalOne) {
  bus_.Plug(Vec());
  auto pedal = Open({});
  FootPedal* raw = pedal.get();
  PedalledDevice device(std::make_unique<PointerDevice>(5e-6, 1e-3), std::move(pedal));
  EXPECT_EQ(device.ReadSample().buttons, 0);
  const uint8_t down[] = {0x04, 0x00};
  bus_.Send(Vec().path, down);
  ASSERT_TRUE(Becomes(*raw, kPedal));
  DeviceSample s = device.ReadSample();
  EXPECT_EQ(s.buttons, kPedal);
  EXPECT_EQ(s.bur_speed_krpm, kTurbineSpeed_krpm);
  EXPECT_FALSE(device.has_motors());
}

}  // namespace
}  // namespace enamel::station::hid
