#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <thread>

#include "common/scene/builtin/builtin.h"
#include "common/scene/cell.h"
#include "common/scene/find_profile.h"
#include "station/desk/device_offers.h"
#include "station/devices/trouble.h"
#include "station/sdk/buses.h"
#include "station/sdk/frames.h"
#include "station/sdk/makers_library.h"
#include "station/sdk/open_sdk_device.h"
#include "tests/station/hid/hid_double.h"
#include "tests/station/sdk/doubled_arm.h"
#include "tests/support/await_sample.h"
#include "tests/support/temp_folder.h"

namespace enamel::station::sdk {
namespace {

using testing_support::DoubledArm;
using State = DoubledArm::State;
using testing_support::HidBus;
using testing_support::ScriptedHid;

class SdkDeviceTest : public testing::Test {
 protected:
  SdkDeviceTest() { Reset(); }
  ~SdkDeviceTest() override {
    device_.reset();
    Reset();
  }
  static void Reset() { HidBus::Get().Reset(); }
  // Attaches a device.
  DoubledArm& Attach(const char* driver, const char* name) {
    arms_.push_back(std::make_unique<DoubledArm>(driver, name));
    return *arms_.back();
  }
  void Open(const char* choice, const char* pedal = "") {
    hid::DeviceChoice chosen;
    chosen.device = choice;
    chosen.pedal = pedal;
    auto device = OpenChosenDevice(chosen, scene::BuiltinProfiles()[0], 1e-3);
    ASSERT_TRUE(device.ok()) << device.status().message();
    device_ = std::move(*device);
    Until([](const DeviceSample& s) { return s.fresh; });
  }
  DeviceSample Until(const std::function<bool(const DeviceSample&)>& wanted) {
    return test::AwaitSample(*device_, wanted);
  }
  using Force = std::array<double, 3>;
  // Sends `force` as the loop does, until the device has heard `wanted`. What it heard last: where this thread has to
  // wait for its turn, the device lets a force that is old fade, and the next is whole again.
  Force Heard(DoubledArm& sdk, const dvec3& force, const Force& wanted) {
    Force heard{};
    for (int i = 0; i < 10'000 && heard != wanted; ++i) {
      device_->SendForce(force);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      heard = sdk.Get().force;
    }
    return heard;
  }

  std::vector<std::unique_ptr<DoubledArm>> arms_;
  std::unique_ptr<Device> device_;
};

TEST_F(SdkDeviceTest, ModelNamesBecomeProfileNames) {
  EXPECT_EQ(ProfileNameOf("omega.3"), "omega3");
  EXPECT_EQ(ProfileNameOf("PHANTOM Desktop"), "phantom_desktop");
  EXPECT_EQ(ProfileNameOf(" Touch - X  "), "touch_x");
  EXPECT_EQ(ProfileNameOf("\xc3\xa9?!"), "");
  // The built-in profiles are found by the names in their makers' libraries.
  auto profiles = scene::BuiltinProfiles();
  EXPECT_EQ(profiles[0].name, ProfileNameOf("omega.3"));
  EXPECT_EQ(profiles[1].name, ProfileNameOf("Phantom Desktop"));
  EXPECT_TRUE(scene::FindProfile(ProfileNameOf("Touch")).ok());
}

TEST_F(SdkDeviceTest, WhatALibraryFindsIsListedAndClosedAgain) {
  EXPECT_EQ(Drivers(), (std::vector<std::string>{"dhd", "openhaptics", "woodenhaptics", "polhem",
                                                 "polhem_serial", "inverse3", "falcon"}));
  EXPECT_TRUE(ListSdkDevices().empty());
  for (const std::string& driver : Drivers()) EXPECT_TRUE(CheckLibrary(driver).ok()) << driver;
  DoubledArm& sdk = Attach("dhd", "omega.3");
  auto found = ListSdkDevices();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].choice, "dhd");
  EXPECT_EQ(found[0].name, "omega.3");
  EXPECT_EQ(found[0].profile, "omega3");
  EXPECT_EQ(sdk.Get().open, 0);
  EXPECT_FALSE(sdk.Get().motors);
}

TEST_F(SdkDeviceTest, TheWindowOffersThemBetweenBoardsAndMice) {
  Attach("dhd", "omega.3");
  Attach("openhaptics", "PHANTOM Desktop");
  auto offers = desk::DeviceOffers(language::Words(language::Language::kEnglish), false, {});
  ASSERT_EQ(offers.size(), 3u);
  EXPECT_EQ(offers[0].title, "omega.3");
  EXPECT_EQ(offers[0].device, "dhd");
  EXPECT_EQ(offers[0].profile, "omega3");
  EXPECT_EQ(offers[0].problem, "");
  EXPECT_EQ(offers[1].device, "openhaptics");
  EXPECT_EQ(offers[1].profile, "phantom_desktop");
  EXPECT_EQ(desk::FirstUsable(offers, ""), 0u);
  EXPECT_EQ(offers[2].profile, "pointer");
}

TEST_F(SdkDeviceTest, ForceDimensionsAxesAreTurnedToTheSceneAndBack) {
  DoubledArm& sdk = Attach("dhd", "omega.3");
  Open("dhd");
  EXPECT_EQ(device_->Name(), "omega.3");
  const double count = scene::CountNm(scene::BuiltinProfiles()[0]) * 1e-9;
  // Toward the user 100 counts, right 200, up 300.
  sdk.With([&](State& s) { s.position = {100 * count, 200 * count, 300 * count}; });
  DeviceSample at = Until([](const DeviceSample& s) { return s.counts[2] == 300; });
  EXPECT_EQ(at.counts, (std::array<int32_t, 3>{200, -100, 300}));
  // Right 1 N, away 2, up 3 of the scene: toward the user -2, right 1, up 3.
  const Force wanted{-2, 1, 3};
  EXPECT_EQ(Heard(sdk, dvec3(1, 2, 3), wanted), wanted);
}

// A driven wrist: its frame and its torque are turned like positions and forces.
TEST_F(SdkDeviceTest, ForceDimensionsWristIsReadAndDriven) {
  DoubledArm& sdk = Attach("dhd", "sigma.7");
  EXPECT_EQ(ProfileNameOf("sigma.7"), scene::BuiltinProfiles().back().name);
  // Turned by 90 degrees about its y, to the right: z goes toward the user (x). In the scene that is
  // about x, and z goes to -y.
  sdk.With([](State& s) {
    s.wrist = true;
    s.frame = {{{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}}};
  });
  Open("dhd");
  const DeviceSample at = Until([](const DeviceSample& s) { return s.orientation[0] != 0; });
  const Quat turned = FromQuantised(at.orientation);
  EXPECT_NEAR(turned.x, std::sqrt(0.5), 1e-4);
  EXPECT_NEAR(turned.w, std::sqrt(0.5), 1e-4);
  EXPECT_NEAR(turned.Matrix()[2].y, -1, 1e-4);
  std::array<double, 3> torque{};
  for (int i = 0; i < 10'000 && torque == std::array<double, 3>{}; ++i) {
    device_->SendForceAndTorque(dvec3(1, 2, 3), dvec3(0.1, 0.2, 0.3));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    torque = sdk.Get().torque;
  }
  EXPECT_EQ(torque, (std::array<double, 3>{-0.2, 0.1, 0.3}));
  EXPECT_EQ(sdk.Get().force, (std::array<double, 3>{-2, 1, 3}));
  device_.reset();
  EXPECT_EQ(sdk.Get().torque, (std::array<double, 3>{0, 0, 0}));
}

TEST_F(SdkDeviceTest, OpenHapticsMillimetresAndAxesAreTurnedToTheSceneAndBack) {
  DoubledArm& sdk = Attach("openhaptics", "PHANTOM Desktop");
  Open("openhaptics");
  const double count_mm = scene::CountNm(scene::BuiltinProfiles()[0]) * 1e-6;
  // Right 100 counts, up 200, toward the user 300.
  sdk.With([&](State& s) {
    s.position = {100 * count_mm, 200 * count_mm, 300 * count_mm};
    s.button = s.second = true;
  });
  DeviceSample at = Until([](const DeviceSample& s) { return s.counts[2] == 200; });
  EXPECT_EQ(at.counts, (std::array<int32_t, 3>{100, -300, 200}));
  EXPECT_EQ(at.buttons, kPedal | kSecond);
  const Force wanted{1, 3, -2};
  EXPECT_EQ(Heard(sdk, dvec3(1, 2, 3), wanted), wanted);
}

TEST_F(SdkDeviceTest, UnpluggedIsSeenAndTheMotorsAreSwitchedOffAtTheEnd) {
  DoubledArm& sdk = Attach("dhd", "omega.3");
  Open("dhd");
  EXPECT_TRUE(sdk.Get().motors);
  sdk.With([](State& s) { s.there = false; });
  EXPECT_FALSE(Until([](const DeviceSample& s) { return !s.attached; }).fresh);
  device_.reset();
  EXPECT_FALSE(sdk.Get().motors);
  EXPECT_EQ(sdk.Get().open, 0);
  EXPECT_EQ(sdk.Get().force, (std::array<double, 3>{}));
}

TEST_F(SdkDeviceTest, APoseThatIsNoNumberIsSilenceAndNotAPlace) {
  DoubledArm& sdk = Attach("dhd", "omega.3");
  Open("dhd");
  sdk.With([](State& s) { s.position[1] = std::numeric_limits<double>::quiet_NaN(); });
  for (int i = 0; i < 10'000 && device_->counters().refused < 10; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GE(device_->counters().refused, 10u);
  (void)device_->ReadSample();
  DeviceSample s = device_->ReadSample();
  EXPECT_FALSE(s.fresh);
  EXPECT_EQ(s.counts, (std::array<int32_t, 3>{}));
}

TEST_F(SdkDeviceTest, ATransformThatIsNoRotationTurnsNothing) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  using Frame = std::array<std::array<double, 3>, 3>;
  const Frame kNoRotations[] = {{},
                                {{{1, 0, 0}, {0, kNone, 0}, {0, 0, 1}}},
                                {{{1e300, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                {{{1, 0, 0}, {1, 0, 0}, {1, 0, 0}}},
                                {{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}}};
  for (const auto& [driver, name] : {std::pair{"dhd", "sigma.7"}, {"openhaptics", "Touch"}}) {
    DoubledArm& sdk = Attach(driver, name);
    sdk.With([](State& s) { s.wrist = true; });
    auto bus = std::string(driver) == "dhd" ? OpenForceDimension({"", 5, 0.1})
                                            : OpenOpenHaptics({"", 5, 0.1});
    ASSERT_TRUE(bus.ok()) << bus.status().message();
    const Frame upright = sdk.Get().frame;
    for (const Frame& frame : kNoRotations) {
      // A frame that was under way before is still heard.
      const auto heard = [&](PolledBus::Heard wanted) {
        PolledBus::Pose pose;
        for (int i = 0; i < 1'000; ++i) {
          if ((*bus)->Read(pose) == wanted) return true;
        }
        return false;
      };
      sdk.With([&](State& s) { s.frame = frame; });
      EXPECT_TRUE(heard(PolledBus::Heard::kRefused)) << driver;
      EXPECT_FALSE(std::string(driver) == "dhd" && heard(PolledBus::Heard::kPose));
      sdk.With([&](State& s) { s.frame = upright; });
      EXPECT_TRUE(heard(PolledBus::Heard::kPose)) << driver;
    }
    bus->reset();
    arms_.clear();
  }
}

TEST_F(SdkDeviceTest, ColumnsOfARotationAreItsQuaternion) {
  // A quarter about z: x goes to y.
  const auto turn = QuatOfColumns({0, 1, 0}, {-1, 0, 0}, {0, 0, 1});
  ASSERT_TRUE(turn);
  EXPECT_NEAR(turn->z, std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(turn->w, std::sqrt(0.5), 1e-12);
  EXPECT_FALSE(QuatOfColumns({0, 1, 0}, {1, 0, 0}, {0, 0, 1})) << "a mirror";
  EXPECT_FALSE(QuatOfColumns({0, 0, 0}, {0, 0, 0}, {0, 0, 0}));
}

TEST_F(SdkDeviceTest, AFootPedalGoesWithAMakersDevice) {
  ScriptedHid vec;
  vec.path = "/dev/hidraw7";
  vec.vendor = 0x05f3;
  vec.product = 0x00ff;
  HidBus::Get().Plug(vec);
  Attach("dhd", "omega.3");
  Open("dhd", "05f3:00ff");
  ASSERT_TRUE(HidBus::Get().Await([](HidBus& b) { return b.handle_count() == 1; }));
  const uint8_t down[] = {0x01, 0x00};
  HidBus::Get().Send(vec.path, down);
  EXPECT_EQ(Until([](const DeviceSample& s) { return s.buttons == kPedal; }).bur_speed_krpm,
            kTurbineSpeed_krpm);
}

TEST_F(SdkDeviceTest, OpenHapticsStylusIsTurnedToTheScene) {
  DoubledArm& sdk = Attach("openhaptics", "Touch");
  Open("openhaptics");
  const auto bur = [](const DeviceSample& s) {
    return FromQuantised(s.orientation).Matrix() * dvec3(0, 0, -1);
  };
  EXPECT_NEAR(bur(device_->ReadSample()).z, -1, 1e-3);
  // Its frame is the library's: -z is away from the user, and x to the right.
  sdk.With([](State& s) { s.frame = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; });
  const DeviceSample ahead = Until([&](const DeviceSample& s) { return bur(s).y > 0.999; });
  EXPECT_NEAR((FromQuantised(ahead.orientation).Matrix() * dvec3(1, 0, 0)).x, 1, 1e-3);
}

TEST_F(SdkDeviceTest, AGrippersClosingRunsTheBur) {
  DoubledArm& sdk = Attach("dhd", "omega.7");
  sdk.With([](State& s) { s.gripper = true; });
  Open("dhd");
  EXPECT_TRUE(sdk.Get().button_by_gripper);
  sdk.With([](State& s) { s.button = true; });
  Until([](const DeviceSample& s) { return s.buttons == kPedal; });
}

TEST_F(SdkDeviceTest, OneThatIsNotCalibratedIsRefusedAndListedWithWhatToDo) {
  for (const auto& [driver, name, expected] :
       {std::array{"dhd", "omega.3", "calibration pit"}, {"openhaptics", "Touch", "inkwell"}}) {
    DoubledArm& sdk = Attach(driver, name);
    sdk.With([](State& s) { s.calibrated = false; });
    hid::DeviceChoice choice;
    choice.device = driver;
    const Status refused = OpenChosenDevice(choice, scene::BuiltinProfiles()[0], 1e-3).status();
    EXPECT_EQ(refused.code(), Code::kUnavailable);
    EXPECT_NE(refused.message().find(expected), std::string::npos) << refused.message();
    EXPECT_FALSE(sdk.Get().motors);
    EXPECT_EQ(sdk.Get().open, 0);
    const auto found = ListSdkDevices();
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NE(found[0].problem.message().find(expected), std::string::npos)
        << found[0].problem.message();
    EXPECT_NE(found[0].problem.field(), trouble::kDevice) << found[0].problem.message();
    arms_.clear();
  }
}

// The device's own reasons: it was too fast, or it heard nothing; and somebody's, its button. Without the
// station's thread, which would let the force fall while this one waits for its turn.
TEST_F(SdkDeviceTest, MotorsThatTheDeviceSwitchesOffAreAFaultAndComeBackAtForceZero) {
  constexpr int kButton = 1, kVelocity = 2, kWatchdog = 3;
  DoubledArm& sdk = Attach("dhd", "omega.3");
  auto bus = OpenForceDimension({"", 5, 0.1});
  ASSERT_TRUE(bus.ok()) << bus.status().message();
  // Over several looks at the device's status.
  const auto exchange = [&](const dvec3& force_n) {
    PolledBus::Pose pose;
    const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(40);
    for (int i = 0; i < 100 || std::chrono::steady_clock::now() < until; ++i) {
      EXPECT_TRUE((*bus)->Send(force_n));
      EXPECT_EQ((*bus)->Read(pose), PolledBus::Heard::kPose);
    }
    return pose.driven;
  };
  for (const int cause : {kVelocity, kWatchdog, kButton}) {
    EXPECT_TRUE(exchange(dvec3(0, 0, 1)));
    sdk.With([&](State& s) {
      s.motors = false;
      s.off_cause = cause;
    });
    EXPECT_FALSE(exchange(dvec3(0, 0, 1))) << "stays off while the loop pushes";
    EXPECT_FALSE(sdk.Get().motors);
    EXPECT_EQ(exchange(dvec3(0)), cause != kButton);
    EXPECT_EQ(sdk.Get().motors, cause != kButton);
  }
}

TEST_F(SdkDeviceTest, ALibraryThatSwitchesTheForceOffIsAFault) {
  DoubledArm& sdk = Attach("openhaptics", "Touch");
  Open("openhaptics");
  sdk.With([](State& s) { s.motors = false; });
  EXPECT_TRUE(Until([](const DeviceSample& s) { return !s.driven; }).attached);
}

TEST_F(SdkDeviceTest, TheFirmwaresWatchdogIsSetWhereItHasOne) {
  DoubledArm& sdk = Attach("dhd", "omega.3");
  Open("dhd");
  EXPECT_EQ(sdk.Get().watchdog_us, 20'000);
}

TEST_F(SdkDeviceTest, ALibraryThatIsMissingTooOldOrLacksAFunctionIsNamed) {
  Attach("dhd", "omega.3");
  const std::string folder = ENAMEL_MAKERS_DOUBLES;
  for (const auto& [file, expected] :
       {std::pair{std::string("/nowhere/libdhd.so.3"), "/nowhere/libdhd.so.3: cannot open"},
        {folder + "/libdhd_double_old.so", "version 3.2.0, expected 3.3.2 or newer"},
        {folder + "/libdhd_double_lacking.so", "has no function dhdSetWatchdog"},
        {folder + "/libHD.so.3.4", "has no function dhdGetSDKVersion"}}) {
    hid::DeviceChoice choice;
    choice.device = "dhd:" + file;
    const Status refused = OpenChosenDevice(choice, scene::BuiltinProfiles()[0], 1e-3).status();
    EXPECT_EQ(refused.code(), Code::kUnavailable);
    EXPECT_NE(refused.message().find(expected), std::string::npos) << refused.message();
    EXPECT_NE(refused.message().find("Force Dimension's SDK"), std::string::npos)
        << refused.message();
  }
}

// What `doctor` says where the maker's device is plugged in, and its library is not there.
TEST_F(SdkDeviceTest, ADeviceWithoutItsLibraryIsListedWithWhatIsMissing) {
  const test::TempFolder usb;
  const auto plug = [&](const char* place, const char* vendor, const char* product) {
    std::filesystem::create_directory(usb.path() / place);
    std::ofstream(usb.path() / place / "idVendor") << vendor << "\n";
    std::ofstream(usb.path() / place / "idProduct") << product << "\n";
  };
  plug("1-1", "1451", "0402");
  plug("1-2", "0403", "6001");
  plug("1-3", "0403", "cb48");
  const std::array nodes{kForceDimensionNodes[0], kFalconNodes[0]};
  const MakersLibrary::Names names{"Maker", "dhd", {"libx.so", ""}, nodes, "it"};
  const auto found = WithoutLibrary(names, Status(Code::kUnavailable, "no library"), usb.path());
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].ids, "0403:cb48");
  EXPECT_EQ(found[1].ids, "1451:0402");
  EXPECT_EQ(found[1].problem.message(), "no library");
}

TEST_F(SdkDeviceTest, WithoutADeviceTheLibraryIsQuotedWithWhatToDo) {
  hid::DeviceChoice choice;
  choice.device = "dhd";
  Status refused = OpenChosenDevice(choice, scene::BuiltinProfiles()[0], 1e-3).status();
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find("no device found"), std::string::npos) << refused.message();
  choice.device = "dhdx";
  EXPECT_EQ(OpenChosenDevice(choice, scene::BuiltinProfiles()[0], 1e-3).status().code(),
            Code::kInvalidInput);
}

}  // namespace
}  // namespace enamel::station::sdk
