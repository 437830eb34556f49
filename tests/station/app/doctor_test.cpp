#include "station/app/doctor.h"

#include <gtest/gtest.h>

#include "station/lab/devices/emulated_inverse3.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

TEST(DoctorTest, TheDelayOfAnInverse3sAnswersIsSaidBesideItsProfiles) {
  const test::TempFolder folder;
  lab::EmulatedInverse3 service;
  service.Delay(std::chrono::milliseconds(3), std::chrono::microseconds(100));
  sdk::SdkDevice device{
      service.choice(), "Inverse3 049D", "inverse3", "", "inverse3:049D", "", true};
  Finding finding = DelayOf(folder.path(), device);
  EXPECT_EQ(finding.verdict, Verdict::kWarn);
  for (const char* said :
       {"Inverse3 049D", "ticks of delay", "99 of 100 answers within", "Profile inverse3 says 2"}) {
    EXPECT_NE(finding.found.find(said), std::string::npos) << finding.found;
  }
  EXPECT_NE(finding.advice.find("calibrate"), std::string::npos) << finding.advice;
  // One in use is not opened.
  device.problem = "it is in use";
  const uint64_t asked = service.requests();
  finding = DelayOf(folder.path(), device);
  EXPECT_EQ(finding.found.find("answers within"), std::string::npos) << finding.found;
  EXPECT_EQ(service.requests(), asked);
}

}  // namespace
}  // namespace enamel::station
