#include "station/app/doctor.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>

#include "common/base/file.h"
#include "station/devices/trouble.h"
#include "station/lab/devices/emulated_inverse3.h"
#include "station/session/device_delay.h"
#include "tests/support/opens_with.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

TEST(DoctorTest, TheDelayOfAnInverse3sAnswersIsSaidBesideItsProfiles) {
  const test::TempFolder folder;
  lab::EmulatedInverse3 service;
  service.Delay(std::chrono::milliseconds(3), std::chrono::microseconds(100));
  sdk::SdkDevice device{service.choice(), "Inverse3 049D", "inverse3", "",
                        "inverse3:049D",  Status::Ok(),    true};
  Finding finding = DelayOf(folder.path(), device);
  EXPECT_EQ(finding.verdict, Verdict::kWarn);
  for (const char* said :
       {"Inverse3 049D", "ticks of delay", "99 of 100 answers within", "Profile inverse3 says 2"}) {
    EXPECT_NE(finding.found.find(said), std::string::npos) << finding.found;
  }
  EXPECT_NE(finding.advice.find("calibrate"), std::string::npos) << finding.advice;
  EXPECT_EQ(finding.found.find("calibrated"), std::string::npos) << finding.found;
  // Beside the jitter of its calibration, if there is one.
  scene::Calibration calibration;
  calibration.device = calibration.software = calibration.method = "test";
  calibration.profile = "inverse3";
  calibration.answer_jitter_us = scene::Measured{430, 40, 5000};
  std::filesystem::create_directories(CalibrationsFolder(folder.path()));
  ASSERT_TRUE(WriteFileDurably(CalibrationFile(folder.path(), device.unit),
                               AsBytes(scene::ToJson(calibration)))
                  .ok());
  lab::EmulatedInverse3 another;  // the first may take a moment to see that it was closed
  device.choice = another.choice();
  finding = DelayOf(folder.path(), device);
  EXPECT_NE(finding.found.find("0.43 ms when it was calibrated"), std::string::npos)
      << finding.found;
  // One in use is not opened.
  device.problem = Status(Code::kUnavailable, "it is in use", "in_use");
  const uint64_t asked = another.requests();
  finding = DelayOf(folder.path(), device);
  EXPECT_EQ(finding.found.find("answers within"), std::string::npos) << finding.found;
  EXPECT_EQ(another.requests(), asked);
}

TEST(DoctorTest, ADeviceIsNamedWithItsDriverAndWhatIsMissing) {
  sdk::SdkDevice falcon{"falcon",
                        "Novint Falcon",
                        "falcon",
                        "0403:cb48",
                        "falcon:usb:1-2",
                        Status(Code::kUnavailable, "firmware missing: put it there", "firmware"),
                        true};
  Finding finding = DevicesOf({}, {falcon});
  EXPECT_EQ(finding.verdict, Verdict::kFail);
  EXPECT_EQ(finding.found,
            "0403:cb48: Novint Falcon, driver falcon, firmware missing: put it there");
  falcon.problem = {};
  finding = DevicesOf({}, {falcon, falcon});
  EXPECT_EQ(finding.verdict, Verdict::kOk);
  EXPECT_EQ(finding.found,
            "0403:cb48: Novint Falcon, driver falcon; 0403:cb48: Novint Falcon, driver falcon");
  EXPECT_EQ(DevicesOf({}, {}).verdict, Verdict::kWarn);
}

TEST(DoctorTest, ADeviceThatCannotBeOpenedIsAFailureWithTheRemedy) {
  hid::HidInfo mouse;
  mouse.path = "/dev/hidraw3";
  mouse.vendor = 0x256f;
  mouse.product = 0xc62e;
  mouse.usage_page = 1;
  mouse.usage = 8;
  const test::OpensWith call([](const char*, int) {
    errno = EPERM;
    return -1;
  });
  const Finding finding = DevicesOf({mouse}, {});
  EXPECT_EQ(finding.verdict, Verdict::kFail);
  EXPECT_NE(finding.found.find("DeviceAllow=char-hidraw rw"), std::string::npos) << finding.found;
}

// Its file can be opened, and nothing in it answers.
TEST(DoctorTest, ABoardThatDoesNotDescribeItselfIsAFailure) {
  hid::HidInfo board;
  board.path = "/dev/null";
  board.usage_page = hid::kBoardUsagePage;
  board.usage = hid::kBoardUsage;
  const Finding finding = DevicesOf({board}, {});
  EXPECT_EQ(finding.verdict, Verdict::kFail);
  EXPECT_NE(finding.found.find("/dev/null"), std::string::npos) << finding.found;
}

TEST(DoctorTest, AnInverse3WithoutAGripFailsAndWithAFootPedalWarns) {
  const sdk::SdkDevice arm{"inverse3",
                           "Inverse3 049D",
                           "inverse3",
                           "",
                           "inverse3:049D",
                           Status(Code::kUnavailable, "no grip is connected", trouble::kNoGrip),
                           true};
  EXPECT_EQ(DevicesOf({}, {arm}).verdict, Verdict::kFail);
  hid::HidInfo pedal;
  pedal.path = "/dev/null";
  pedal.vendor = 0x05f3;
  pedal.product = 0x00ff;
  const Finding finding = DevicesOf({pedal}, {arm});
  EXPECT_EQ(finding.verdict, Verdict::kWarn);
  EXPECT_NE(finding.found.find("no grip is connected"), std::string::npos) << finding.found;
}

}  // namespace
}  // namespace enamel::station
