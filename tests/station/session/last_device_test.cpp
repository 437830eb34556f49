#include "station/session/last_device.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

TEST(LastDeviceTest, IsTheOneThatWasKeptLast) {
  test::TempFolder folder;
  EXPECT_FALSE(LastDeviceOf(folder.path()));
  const LastDevice arm{"Bench \"arm\"", "phantom_desktop"}, other{"Falcon", "falcon"};
  ASSERT_TRUE(KeepLastDevice(folder.path(), arm).ok());
  EXPECT_EQ(LastDeviceOf(folder.path()), arm);
  ASSERT_TRUE(KeepLastDevice(folder.path(), other).ok());
  EXPECT_EQ(LastDeviceOf(folder.path()), other);
}

TEST(LastDeviceTest, AFileOfAnotherKindCountsAsNone) {
  test::TempFolder folder;
  for (const std::string text :
       {"", "[]", R"({"enamel_last_device":1})", R"({"enamel_last_device":1,"title":"Arm"})",
        R"({"enamel_last_device":2,"title":"Arm","profile":"arm"})",
        R"({"enamel_last_device":1,"title":1,"profile":"arm"})",
        R"({"enamel_last_device":1,"title":"","profile":"arm"})",
        R"({"enamel_last_device":1,"title":"Arm","profile":""})",
        R"({"enamel_last_device":1,"title":"Arm","profile":"arm")"}) {
    std::ofstream(folder.path() / "last_device.json") << text;
    EXPECT_FALSE(LastDeviceOf(folder.path())) << text;
  }
}

}  // namespace
}  // namespace enamel::station
