#include "common/program/input.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iostream>
#include <sstream>

#include "tests/support/temp_folder.h"

namespace enamel::program {
namespace {

// Standard input has this text while it lives.
class StandardInput {
 public:
  explicit StandardInput(const std::string& text) : text_(text), before_(std::cin.rdbuf()) {
    std::cin.rdbuf(text_.rdbuf());
  }
  ~StandardInput() {
    std::cin.rdbuf(before_);
    std::cin.clear();
  }

 private:
  std::istringstream text_;
  std::streambuf* before_;
};

TEST(InputTest, FileIsReadWhole) {
  test::TempFolder folder;
  std::ofstream(folder.path() / "names") << "Chair 1\nChair 2\n";
  auto text = ReadInput(folder.path() / "names", 16);
  ASSERT_TRUE(text.ok()) << text.status().message();
  EXPECT_EQ(*text, "Chair 1\nChair 2\n");
}

TEST(InputTest, DashIsStandardInput) {
  StandardInput input("Chair 1\n");
  auto text = ReadInput("-", 100);
  ASSERT_TRUE(text.ok()) << text.status().message();
  EXPECT_EQ(*text, "Chair 1\n");
}

TEST(InputTest, MoreThanAllowedIsRefused) {
  StandardInput input("Chair 1\n");
  EXPECT_EQ(ReadInput("-", 7).status().code(), Code::kTooLarge);
}

TEST(InputTest, AsMuchAsAllowedIsTaken) {
  StandardInput input("Chair 1\n");
  auto text = ReadInput("-", 8);
  ASSERT_TRUE(text.ok()) << text.status().message();
  EXPECT_EQ(text->size(), 8u);
}

}  // namespace
}  // namespace enamel::program
