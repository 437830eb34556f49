#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

#include "common/scene/cell.h"
#include "common/scene/find_profile.h"
#include "station/devices/trouble.h"
#include "station/sdk/buses.h"
#include "station/sdk/falcon_arm.h"
#include "station/sdk/open_sdk_device.h"
#include "tests/station/sdk/emulated_falcon.h"
#include "tests/station/sdk/usb_double.h"
#include "tests/support/await_sample.h"
#include "tests/support/temp_folder.h"

// Claims about the Falcon alone. Those about every device are in arms_test.cpp.
namespace enamel::station::sdk {
namespace {

using falcon::kMiddle_m;
using testing_support::EmulatedFalcon;
using testing_support::FalconAnglesAt;
using testing_support::ScriptedUsb;
using testing_support::UsbBus;

Result<std::unique_ptr<Device>> Open(const EmulatedFalcon& arm) {
  hid::DeviceChoice choice;
  choice.device = arm.choice();
  return OpenChosenDevice(choice, *scene::FindProfile(arm.profile()), 1e-3);
}

std::unique_ptr<Device> MustOpen(const EmulatedFalcon& arm) {
  auto device = Open(arm);
  EXPECT_TRUE(device.ok()) << device.status().message();
  if (!device.ok()) return nullptr;
  test::AwaitSample(**device, [](const DeviceSample& s) { return s.fresh; });
  return std::move(*device);
}

BusChoice Choice(const EmulatedFalcon& arm) {
  BusChoice out{arm.firmware_file(), 5, 0.04};
  out.for_hand = std::chrono::milliseconds(200);
  return out;
}

void ExpectRefused(const Status& status, std::initializer_list<const char*> said) {
  EXPECT_EQ(status.code(), Code::kUnavailable);
  for (const char* text : said) {
    EXPECT_NE(status.message().find(text), std::string::npos) << status.message();
  }
}

// What it says of a place, m in its own frame, as the loop has it; within two counts.
void ExpectCounts(Device& device, const dvec3& moved_m) {
  const auto profile = *scene::FindProfile("falcon");
  const double cell_m = scene::CountNm(profile) * 1e-9;
  const dvec3 scene{moved_m.x, -moved_m.z, moved_m.y};
  const auto off = [&](const DeviceSample& s) {
    double most = 0;
    for (int i = 0; i < 3; ++i) {
      most = std::max(most, std::abs(s.counts[static_cast<size_t>(i)] * cell_m - scene[i]));
    }
    return most;
  };
  const DeviceSample s = test::AwaitSample(device, [&](const DeviceSample& sample) {
    return off(sample) < 2e-9 * static_cast<double>(profile.resolution_nm.value);
  });
  EXPECT_LT(off(s), 2e-9 * static_cast<double>(profile.resolution_nm.value));
}

// Nobody homes it.
void OffAndOn(EmulatedFalcon& arm) {
  arm.SwitchOff();
  arm.SwitchOn();
  arm.HomeWhenRed(false);
}

TEST(FalconTest, ItsTipHasTheScenesAxes) {
  EmulatedFalcon arm;
  auto device = MustOpen(arm);
  for (const dvec3& moved : {dvec3(0.01, 0, 0), dvec3(0, 0.02, 0), dvec3(0, 0, -0.015),
                             dvec3(-0.02, 0.01, 0.02), dvec3(0)}) {
    arm.Set(kMiddle_m + moved);
    ExpectCounts(*device, moved);
  }
}

// A motor value is -10000 of a N m; over a thigh's turn its work is the force's over the tip's way.
TEST(FalconTest, ItsMotorsDoTheForcesWork) {
  EmulatedFalcon arm;
  const dvec3 place = kMiddle_m + dvec3(0.01, -0.015, 0.02);
  arm.Set(place);
  auto bus = OpenFalcon(Choice(arm));
  ASSERT_TRUE(bus.ok()) << bus.status().message();
  const dvec3 to_scene{1.5, 2.0, -1.0}, force{1.5, -1.0, -2.0};  // x, -z, y
  PolledBus::Pose pose;
  ASSERT_TRUE((*bus)->Send(to_scene));
  ASSERT_EQ((*bus)->Read(pose), PolledBus::Heard::kPose);
  for (const dvec3& way : {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1), dvec3(1, -2, 3)}) {
    constexpr double kWay_m = 1e-6;
    const dvec3 turns = FalconAnglesAt(place + way * kWay_m) - FalconAnglesAt(place);
    double work_j = 0;
    for (int i = 0; i < 3; ++i) work_j += arm.told()[static_cast<size_t>(i)] / -1e4 * turns[i];
    // Counts put the tip up to 50 um elsewhere, and values are whole.
    EXPECT_NEAR(work_j / kWay_m, Dot(force, way), 0.01);
  }
}

TEST(FalconTest, ForcesBeyondItsMotorsKeepTheirDirection) {
  EmulatedFalcon arm;
  BusChoice choice = Choice(arm);
  choice.peak_n = 1000;
  auto bus = OpenFalcon(choice);
  ASSERT_TRUE(bus.ok()) << bus.status().message();
  const auto told = [&](const dvec3& force) {
    PolledBus::Pose pose;
    EXPECT_TRUE((*bus)->Send(force));
    EXPECT_EQ((*bus)->Read(pose), PolledBus::Heard::kPose);
    return arm.told();
  };
  const dvec3 force{0.5, 2.5, 1.5};
  const auto weak = told(force), strong = told(force * 100.0);
  int most = 0;
  for (size_t i = 0; i < 3; ++i) {
    most = std::max(most, std::abs(strong[i]));
    EXPECT_NEAR(1.0 * strong[i] / strong[0], 1.0 * weak[i] / weak[0], 0.01);
  }
  EXPECT_EQ(most, 4096);
}

TEST(FalconTest, AfterPowerUpItGetsItsFirmwareOnceAndIsHomedWhileItsLightIsRed) {
  EmulatedFalcon arm;
  OffAndOn(arm);
  arm.HomeWhenRed(true);
  auto device = MustOpen(arm);
  EXPECT_EQ(arm.uploads(), 1);
  EXPECT_EQ(arm.lights(), 4);  // blue
  device.reset();
  for (int i = 0; i < 1000 && arm.lights() != 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(arm.lights(), 0);
  MustOpen(arm);
  EXPECT_EQ(arm.uploads(), 1);
}

TEST(FalconTest, AnUploadThatComesBackOtherwiseIsMadeAgainTenTimes) {
  EmulatedFalcon arm;
  OffAndOn(arm);
  arm.HomeWhenRed(true);
  arm.SpoilUploads(3);
  MustOpen(arm);
  EXPECT_EQ(arm.uploads(), 4);
  OffAndOn(arm);
  arm.SpoilUploads(100);
  ExpectRefused(Open(arm).status(), {"in ten tries", "switch it off and on"});
  EXPECT_EQ(arm.uploads(), 14);
}

TEST(FalconTest, OneThatIsNotHomedIsRefusedWithHowToDoIt) {
  EmulatedFalcon arm;
  arm.SetHomed(false);
  ExpectRefused(OpenFalcon(Choice(arm)).status(), {"pull its grip out", "push it in", "blue"});
  EXPECT_EQ(arm.told(), (std::array<int, 3>{}));
}

TEST(FalconTest, WithoutFirmwareItIsListedAndRefusedWithWhatIsMissing) {
  EmulatedFalcon arm;
  const auto listed = [&](const std::string& file) {
    const auto all = FindFalconWith(file);
    EXPECT_EQ(all.size(), 1u);
    return all.front();
  };
  SdkDevice found = listed("/none");
  EXPECT_EQ(found.ids + " " + found.name + " " + found.unit + found.problem.message(),
            "0403:cb48 Novint Falcon falcon:usb:1-2");
  EXPECT_TRUE(scene::FindProfile(found.profile).ok());
  OffAndOn(arm);
  EXPECT_TRUE(listed(arm.firmware_file()).problem.ok());
  const std::string missing = listed("/none").problem.message();
  EXPECT_EQ(listed("/none").problem.field(), trouble::kFirmware);
  EXPECT_TRUE(missing.starts_with("firmware missing: put Novint's firmware into /none")) << missing;
  std::filesystem::remove(arm.firmware_file());
  ExpectRefused(Open(arm).status(), {"firmware missing", arm.firmware_file().c_str()});
}

TEST(FalconTest, OneThatMayNotBeUsedOrIsInUseIsListedWithWhatToDo) {
  EmulatedFalcon arm;
  auto device = MustOpen(arm);
  EXPECT_EQ(FindFalcon().front().problem.field(), trouble::kInUse);
  device.reset();
  arm.Unplug();
  EXPECT_TRUE(FindFalcon().empty());
  EXPECT_EQ(Open(arm).status().code(), Code::kNotFound);
  ScriptedUsb locked{0x0403, 0xcb48, false, {}, {}};
  UsbBus::Get().Plug("1-2", locked);
  EXPECT_EQ(FindFalcon().front().problem.field(), trouble::kPermission);
  EXPECT_NE(FindFalcon().front().problem.message().find("60-enamel.rules"), std::string::npos);
}

// Packets of noise, and the chip's own empty ones.
TEST(FalconTest, ALineThatNeverFallsQuietIsRefusedInTime) {
  const test::TempFolder folder;
  std::ofstream(folder.path() / "falcon.bin") << "firmware";
  for (const Bytes& packet : {Bytes{1, 0x60, 'x', '<', 'y'}, Bytes{1, 0x60}}) {
    ScriptedUsb usb{0x0403, 0xcb48};
    usb.control = [](uint8_t, uint16_t) { return false; };
    usb.written = [](ByteView) {};
    usb.endless = packet;
    UsbBus::Get().Plug("1-9", usb);
    const bool noise = packet.size() > 2;
    const std::string file = noise ? folder.path() / "falcon.bin" : folder.path() / "none";
    EXPECT_EQ(OpenFalcon({file, 5, 0.04}).status().field(),
              noise ? trouble::kSilent : trouble::kFirmware);
    UsbBus::Get().Unplug("1-9");
  }
}

// The emulated firmware tells where it is in homing mode only.
TEST(FalconTest, EachFrameKeepsTheHomingModeAndTheLastForceIsZero) {
  EmulatedFalcon arm;
  {
    auto bus = OpenFalcon(Choice(arm));
    ASSERT_TRUE(bus.ok()) << bus.status().message();
    PolledBus::Pose pose;
    for (int i = 0; i < 100; ++i) {
      EXPECT_TRUE((*bus)->Send(dvec3(0, 0, 1)));
      EXPECT_NE((*bus)->Read(pose), PolledBus::Heard::kGone);
    }
    EXPECT_NE(arm.told(), (std::array<int, 3>{}));
  }
  for (int i = 0; i < 10'000 && arm.told() != std::array<int, 3>{}; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(arm.told(), (std::array<int, 3>{}));
}

TEST(FalconTest, ATipAtTheRimOfItsWorkspaceIsRefused) {
  EmulatedFalcon arm;
  arm.Set(kMiddle_m + dvec3(0, 0, 0.045));
  ExpectRefused(Open(arm).status(), {"45 mm", "reaches 40 mm", "move it there"});
}

TEST(FalconTest, HalfFramesAreReadAsWholeOnes) {
  EmulatedFalcon arm;
  arm.InPieces(true);
  auto device = MustOpen(arm);
  arm.Set(kMiddle_m + dvec3(0.01, 0, 0));
  ExpectCounts(*device, {0.01, 0, 0});
}

TEST(FalconTest, AFrameThatLostAByteMovesNothing) {
  for (const int at : {0, 5, 13, 15}) {
    EmulatedFalcon arm;
    auto device = MustOpen(arm);
    arm.LoseByte(at);
    const uint64_t before = arm.requests();
    for (int i = 0; i < 2000 && arm.requests() < before + 10; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const DeviceSample s = device->ReadSample();
    EXPECT_EQ(s.counts, (std::array<int32_t, 3>{})) << at;
    EXPECT_TRUE(s.attached) << at;
    arm.LoseByte(-1);
    arm.Set(kMiddle_m + dvec3(0, 0, -0.01));
    ExpectCounts(*device, {0, 0, -0.01});
  }
}

TEST(FalconTest, CountsThatItsLegsCannotHaveMoveNothing) {
  EmulatedFalcon arm;
  auto device = MustOpen(arm);
  const auto at = arm.counts();
  arm.SetCounts({2500, -2500, -2500});
  const uint64_t before = device->counters().refused;
  for (int i = 0; i < 2000 && device->counters().refused < before + 5; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GE(device->counters().refused, before + 5);
  EXPECT_EQ(device->ReadSample().counts, (std::array<int32_t, 3>{}));
  arm.SetCounts(at);
  test::AwaitSample(*device, [](const DeviceSample& s) { return s.fresh; });
}

TEST(FalconTest, FirmwareThatRestartsCountsAsUnplugged) {
  EmulatedFalcon arm;
  auto device = MustOpen(arm);
  arm.SetHomed(false);
  test::AwaitSample(*device, [](const DeviceSample& s) { return !s.attached; });
}

TEST(FalconTest, ItsCentreButtonRunsTheBurAndNoOtherDoes) {
  EmulatedFalcon arm;
  auto device = MustOpen(arm);
  arm.Press(4);
  test::AwaitSample(*device, [](const DeviceSample& s) { return s.buttons == kPedal; });
  arm.Press(1 + 2 + 8);
  test::AwaitSample(*device, [](const DeviceSample& s) { return s.buttons == 0; });
}

}  // namespace
}  // namespace enamel::station::sdk
