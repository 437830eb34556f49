#include <gtest/gtest.h>

#include "station/desk/desk.h"

namespace enamel::station::desk {
namespace {

TEST(WindowSize, IsTwoWholeNumbers) {
  DeskOptions options;
  ASSERT_TRUE(SetWindowSize("1920x1080", options).ok());
  EXPECT_FALSE(options.full_screen);
  EXPECT_EQ(options.width_px, 1920);
  EXPECT_EQ(options.height_px, 1080);
}

TEST(WindowSize, AnythingElseIsRefusedWithWhatWasFound) {
  for (const char* text : {"", "x", "1280", "1280x", "x720", "-5x-5", "0x0", "1280x720zzz",
                           "1280x-1", "1280 x 720", " 1280x720", "1280x720x3", "99999999999x720",
                           "20000x720", "0x500x2d0", "+1280x720", "1e3x720"}) {
    DeskOptions options;
    Status refused = SetWindowSize(text, options);
    EXPECT_EQ(refused.code(), Code::kInvalidInput) << text;
    EXPECT_NE(refused.message().find("found '" + std::string(text) + "'"), std::string::npos);
    EXPECT_TRUE(options.full_screen) << "and nothing is changed";
  }
}

}  // namespace
}  // namespace enamel::station::desk
