#include "common/program/output.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
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

TEST(OutputTest, NumbersInJsonAreWrittenAsPeopleWriteThem) {
  const boost::json::value value{{"score", 94.0},       {"mean", 87.25},  {"none", nullptr},
                                 {"ticks", 120345},     {"zero", 0.0},    {"tiny", 3e-9},
                                 {"list", {-0.5, 1e6}}, {"a\"b", "9.4E1"}};
  const std::string text = JsonText(value);
  EXPECT_EQ(text, R"({"score":94.0,"mean":87.25,"none":null,"ticks":120345,"zero":0.0,)"
                  R"("tiny":3e-09,"list":[-0.5,1000000.0],"a\"b":"9.4E1"})");
  EXPECT_EQ(boost::json::parse(text), value);
}

}  // namespace
}  // namespace enamel::program
