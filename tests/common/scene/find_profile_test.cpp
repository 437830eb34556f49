#include "common/scene/find_profile.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"

namespace enamel::scene {
namespace {

namespace fs = std::filesystem;

class FindProfileTest : public testing::Test {
 protected:
  FindProfileTest()
      : file_(fs::temp_directory_path() /
              ("enamel-profile-" + std::to_string(getpid()) + ".json")) {}
  ~FindProfileTest() override { fs::remove(file_); }
  void Write(const std::string& text) { std::ofstream(file_, std::ios::binary) << text; }

  fs::path file_;
};

TEST_F(FindProfileTest, NamesABuiltInOneOrADocument) {
  auto built_in = FindProfile("omega3");
  ASSERT_TRUE(built_in.ok());
  DeviceProfile own = *built_in;
  own.name = "own";
  Write(ToJson(own));
  auto found = FindProfile(file_.string());
  ASSERT_TRUE(found.ok()) << found.status().message();
  EXPECT_EQ(found->name, "own");
}

TEST_F(FindProfileTest, SaysWhatThereIsAndWhereADocumentIsWrong) {
  auto unknown = FindProfile("omega4");
  EXPECT_EQ(unknown.status().code(), Code::kNotFound);
  for (const DeviceProfile& p : BuiltinProfiles()) {
    EXPECT_NE(unknown.status().message().find(p.name), std::string::npos)
        << unknown.status().message();
  }
  EXPECT_FALSE(FindProfile("/nowhere/at/all.json").ok());
  DeviceProfile six = BuiltinProfiles()[0];
  six.axes = {6, "the maker"};
  Write(ToJson(six));
  auto refused = FindProfile(file_.string());
  EXPECT_EQ(refused.status().field(), "/torque");
  EXPECT_EQ(refused.status().message().find(file_.string()), 0u) << refused.status().message();
  EXPECT_NE(refused.status().message().find("3: it drives no rotation"), std::string::npos)
      << refused.status().message();
}

}  // namespace
}  // namespace enamel::scene
