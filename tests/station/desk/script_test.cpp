#include "station/desk/script.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace enamel::station::desk {
namespace {

class ScriptTest : public testing::Test {
 protected:
  std::filesystem::path Written(const std::string& text) const {
    std::ofstream(folder_ / "script") << text;
    return folder_ / "script";
  }
  test::TempFolder temp_;
  const std::filesystem::path folder_ = temp_.path();
};

TEST_F(ScriptTest, RemarksAndEmptyLinesAreNoSteps) {
  auto script = Script::Read(Written("# nothing\n\n   \n"));
  ASSERT_TRUE(script.ok());
  EXPECT_FALSE(script->playing());
  EXPECT_TRUE(Script::Read(Written("page sign-in\nquit\n"))->playing());
}

TEST_F(ScriptTest, AnUnknownStepIsRefusedWithItsLine) {
  auto script = Script::Read(Written("page sign-in\n\ndance\n"));
  ASSERT_FALSE(script.ok());
  EXPECT_EQ(script.status().code(), Code::kInvalidInput);
  EXPECT_NE(script.status().message().find(":3: no step 'dance'"), std::string::npos)
      << script.status().message();
}

TEST_F(ScriptTest, AMissingFileIsNamed) {
  auto script = Script::Read(folder_ / "none");
  ASSERT_FALSE(script.ok());
  EXPECT_NE(script.status().message().find("none"), std::string::npos);
}

}  // namespace
}  // namespace enamel::station::desk
