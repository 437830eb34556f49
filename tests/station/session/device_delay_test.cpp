#include "station/session/device_delay.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/base/file.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/find_profile.h"
#include "common/scene/plan.h"
#include "station/lab/devices/emulated_inverse3.h"
#include "station/sdk/open_sdk_device.h"
#include "tests/station/session/log_lines.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

class Attached final : public Device {
 public:
  explicit Attached(bool motors, std::string unit = "hid:1209:0001:SN7")
      : motors_(motors), unit_(std::move(unit)) {}
  std::string Name() const override { return "arm"; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, Name(), "test"); }
  std::string Unit() const override { return unit_; }
  bool has_motors() const noexcept override { return motors_; }
  DeviceSample ReadSample() noexcept override { return {}; }
  void SendForce(const dvec3&) noexcept override {}

 private:
  const bool motors_;
  const std::string unit_;
};

class DeviceDelayTest : public testing::Test {
 protected:
  DeviceDelayTest() {
    auto built = scene::BuildBuiltinScene("block", 200'000);
    EXPECT_TRUE(built.ok());
    prepared_.scene = built->scene;
    prepared_.exercise = scene::ClassOneExercise(built->scene, {});
    prepared_.profile = scene::BuiltinProfiles()[1];
    prepared_.volume = std::move(built->volume);
    prepared_.header.params =
        *scene::CompilePlan(prepared_.scene, prepared_.exercise, prepared_.profile);
  }

  void Keep(const std::string& unit, int64_t ticks) {
    scene::Calibration c;
    c.device = unit;
    c.profile = "phantom_desktop";
    c.software = "test";
    c.method = "test";
    c.bus_delay_ticks = scene::Measured{ticks, 0, 8};
    fs::create_directories(CalibrationsFolder(folder_));
    ASSERT_TRUE(WriteFileDurably(CalibrationFile(folder_, unit), AsBytes(scene::ToJson(c))).ok());
  }
  int32_t Kc() const { return prepared_.header.params.kc_mn_per_mm; }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  PreparedAttempt prepared_;
};

// b = 1.75 N s/m, 1 kHz: 2 b f/4 = 875 mN/mm.
TEST_F(DeviceDelayTest, AnUnmeasuredDeviceIsComputedWithATickAndItIsSaid) {
  LogLines log;
  ASSERT_TRUE(UseDelayOf(prepared_, Attached(true), folder_).ok());
  EXPECT_EQ(Kc(), 875);
  ASSERT_TRUE(prepared_.delay.has_value());
  EXPECT_EQ(*prepared_.delay, (scene::DelayUsed{1, scene::DelayUsed::From::kAssumed, {}}));
  EXPECT_TRUE(log.Has("warning: arm: its delay was never measured")) << log.text();
  EXPECT_TRUE(log.Has("enamel-station calibrate")) << log.text();
  EXPECT_TRUE(log.Has("Kc 875 mN/mm instead of the profile's 2500")) << log.text();
  // The value sent to a server passes its check.
  EXPECT_TRUE(scene::CheckParams(prepared_.scene, prepared_.exercise, prepared_.profile,
                                 prepared_.header.params)
                  .ok());
}

TEST_F(DeviceDelayTest, WhatHasNoMotorsKeepsItsProfile) {
  ASSERT_TRUE(UseDelayOf(prepared_, Attached(false), folder_).ok());
  EXPECT_EQ(Kc(), 2500);
  EXPECT_FALSE(prepared_.delay.has_value());
}

TEST_F(DeviceDelayTest, AMeasurementOfThisUnitLiftsItAndOneOfAnotherDoesNot) {
  Keep("hid:1209:0001:SN8", 0);
  ASSERT_TRUE(UseDelayOf(prepared_, Attached(true), folder_).ok());
  EXPECT_EQ(Kc(), 875);
  Keep("hid:1209:0001:SN7", 0);
  LogLines log;
  ASSERT_TRUE(UseDelayOf(prepared_, Attached(true), folder_).ok());
  EXPECT_EQ(Kc(), 2500);
  EXPECT_FALSE(log.Has("warning")) << log.text();
  // A unit without a distinct name never matches a measured one.
  ASSERT_TRUE(UseDelayOf(prepared_, Attached(true, ""), folder_).ok());
  EXPECT_EQ(Kc(), 875);
  Keep("hid:1209:0001:SN7", 2);
  ASSERT_TRUE(UseDelayOf(prepared_, Attached(true), folder_).ok());
  EXPECT_EQ(Kc(), 388);
}

TEST_F(DeviceDelayTest, ADeviceThatAnswersLaterThanAnAttemptCanBearIsRefusedByName) {
  Keep("hid:1209:0001:SN7", 16);
  EXPECT_TRUE(UseDelayOf(prepared_, Attached(true), folder_).ok());
  Keep("hid:1209:0001:SN7", 17);
  const Status refused = UseDelayOf(prepared_, Attached(true), folder_);
  EXPECT_EQ(refused.field(), "bus_delay_ticks");
  EXPECT_EQ(refused.message().find("arm: 17 ticks of delay"), 0u) << refused.message();
  EXPECT_NE(refused.message().find("connect the device directly"), std::string::npos);
  // Softer than any force that a hand feels, before the core's limit.
  prepared_.profile.damping_mn_s_per_m.value = 100;
  EXPECT_EQ(UseDelayOf(prepared_, Attached(true), folder_).field(), "bus_delay_ticks");
}

TEST_F(DeviceDelayTest, AProfileThatSaysItWasMeasuredIsBelieved) {
  prepared_.profile.delay_measured = true;
  ASSERT_TRUE(UseDelayOf(prepared_, Attached(true), folder_).ok());
  EXPECT_EQ(Kc(), 2500);
}

// b = 1 N s/m, 1 kHz: 2000/(d + 1)^2. The profile has a tick of delay behind the answers.
TEST_F(DeviceDelayTest, AnInverse3WhoseAnswersTakeThreeTicksIsComputedWithThem) {
  prepared_.profile = *scene::FindProfile("inverse3");
  lab::EmulatedInverse3 service;
  hid::DeviceChoice choice;
  choice.device = service.choice();
  for (const int delay_us : {0, 3000}) {
    service.Delay(std::chrono::microseconds(delay_us), std::chrono::microseconds(200));
    auto device = sdk::OpenChosenDevice(choice, prepared_.profile, 1e-3);
    ASSERT_TRUE(device.ok()) << device.status().message();
    LogLines log;
    ASSERT_TRUE(UseDelayOf(prepared_, **device, folder_).ok());
    ASSERT_TRUE(prepared_.delay && prepared_.delay->answers);
    const scene::AnswerTime answers = *prepared_.delay->answers;
    EXPECT_GE(answers.answers, kAnswersToKnow);
    EXPECT_GE(answers.median_us, delay_us);
    EXPECT_GE(answers.p99_us, answers.median_us);
    const int64_t ticks = 1 + std::max<int64_t>(1, (answers.p99_us + 999) / 1000);
    EXPECT_EQ(prepared_.delay->ticks, ticks);
    EXPECT_EQ(prepared_.header.params.bus_delay_ticks, static_cast<uint32_t>(ticks));
    EXPECT_EQ(Kc(), std::min<int64_t>(222, 2000 / ((ticks + 1) * (ticks + 1))));
    EXPECT_TRUE(log.Has("99 of 100 answers within")) << log.text();
    EXPECT_TRUE(scene::CheckParams(prepared_.scene, prepared_.exercise, prepared_.profile,
                                   prepared_.header.params)
                    .ok());
    if (delay_us == 0) continue;
    EXPECT_EQ(prepared_.delay->from, scene::DelayUsed::From::kAnswers);
    EXPECT_LE(Kc(), 2000 / 36);
  }
}

TEST_F(DeviceDelayTest, ABrokenMeasurementCountsAsNoneAndIsSaid) {
  fs::create_directories(CalibrationsFolder(folder_));
  std::ofstream(CalibrationFile(folder_, "hid:1209:0001:SN7")) << "{\"enamel_calibration\": 1";
  LogLines log;
  ASSERT_TRUE(UseDelayOf(prepared_, Attached(true), folder_).ok());
  EXPECT_EQ(Kc(), 875);
  EXPECT_TRUE(log.Has("counts as not measured")) << log.text();
}

TEST_F(DeviceDelayTest, AResumedAttemptKeepsItsParametersOrIsRefusedWhereTheyAreTooStiff) {
  prepared_.core = std::make_unique<core::Core>(prepared_.header.params, prepared_.volume);
  Status refused = UseDelayOf(prepared_, Attached(true), folder_);
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_NE(refused.message().find("875"), std::string::npos) << refused.message();
  EXPECT_EQ(Kc(), 2500);
  prepared_.header.params.kc_mn_per_mm = 800;
  refused = UseDelayOf(prepared_, Attached(true), folder_);
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_EQ(refused.field(), "bus_delay_ticks");
  prepared_.header.params.bus_delay_ticks = 1;
  EXPECT_TRUE(UseDelayOf(prepared_, Attached(true), folder_).ok());
  EXPECT_EQ(Kc(), 800);
}

}  // namespace
}  // namespace enamel::station
