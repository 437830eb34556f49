#include "common/program/output.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_folder.h"

namespace enamel::program {
namespace {

TEST(OutputTest, AFolderThatHoldsTheFileAlreadyIsNoNewOne) {
  test::TempFolder folder;
  EXPECT_TRUE(CheckNewIn(folder.path(), "scene.json", "--out").ok());
  EXPECT_TRUE(CheckNewIn(folder.path() / "none", "scene.json", "--out").ok());
  std::ofstream(folder.path() / "scene.json") << "{}";
  const Status status = CheckNewIn(folder.path(), "scene.json", "--out");
  EXPECT_EQ(status.code(), Code::kConflict);
  EXPECT_NE(status.message().find("scene.json"), std::string::npos) << status.message();
}

}  // namespace
}  // namespace enamel::program
