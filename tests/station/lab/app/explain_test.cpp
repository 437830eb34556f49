#include "station/lab/app/explain.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/json.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

#include "common/base/file.h"
#include "common/scene/builtin/builtin.h"
#include "station/lab/app/qualify.h"
#include "station/lab/suites/joint_front.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;
namespace fs = std::filesystem;

// Runs the command on a coarse scene and reads what it wrote.
class ExplainTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("enamel-explain-" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    options_.scene = "builtin:block";
    options_.exercise = "line";
    options_.voxel_um = 400;
    options_.json = folder_ / "facts.json";
  }
  void TearDown() override { fs::remove_all(folder_); }

  json::object Facts() {
    auto bytes = ReadFile(options_.json);
    EXPECT_TRUE(bytes.ok());
    return bytes.ok() ? json::parse(AsText(*bytes)).as_object() : json::object();
  }

  fs::path folder_;
  ExplainCommand options_;
};

TEST_F(ExplainTest, NamesEveryPartOnceWithAReasonAndNoHashDiffers) {
  ASSERT_TRUE(ExplainScene(options_).ok());
  json::object facts = Facts();
  std::set<std::string> names;
  for (const json::value& v : facts.at("parts").as_array()) {
    const json::object& part = v.as_object();
    EXPECT_TRUE(names.insert(std::string(part.at("part").as_string())).second);
    EXPECT_FALSE(part.at("why").as_string().empty());
    EXPECT_EQ(part.at("measured").as_string().find("DIFFERS"), json::string::npos)
        << part.at("part");
  }
  EXPECT_EQ(names.size(), 15u);
  EXPECT_GT(facts.at("mean_us").as_double(), 0);
  EXPECT_GT(facts.at("engaged_share").as_double(), 0.9);
}

TEST_F(ExplainTest, TorqueIsCarriedOnADeviceThatDrivesRotationAndOnNoOther) {
  auto torque = [&](const char* profile) {
    options_.profile = profile;
    EXPECT_TRUE(ExplainScene(options_).ok());
    const json::object facts = Facts();
    for (const json::value& v : facts.at("parts").as_array()) {
      if (v.at("part") == "torque") return v.as_object();
    }
    return json::object{};
  };
  const json::object kept = torque("sigma7"), left_out = torque("omega3");
  EXPECT_TRUE(kept.at("kept").as_bool());
  // A cost with an interval, or none that can be told from noise: never a bare number.
  EXPECT_TRUE(kept.at("within_noise").as_bool() || kept.at("ns_per_tick").is_object());
  EXPECT_FALSE(left_out.at("kept").as_bool());
  EXPECT_TRUE(left_out.at("ns_per_tick").is_null());
}

TEST_F(ExplainTest, StoringEveryBrickCostsMemory) {
  ASSERT_TRUE(ExplainScene(options_).ok());
  json::object facts = Facts();
  for (const json::value& v : facts.at("parts").as_array()) {
    if (v.at("part").as_string() == "uniform bricks") {
      EXPECT_FALSE(v.at("kept").as_bool());
      EXPECT_GT(v.at("mb").as_double(), 0);
    }
  }
}

TEST_F(ExplainTest, PracticeWithAGenerousBudgetPicksWhatIsFeltBestOfWhatIsProved) {
  options_.budget_us = 1e5;
  options_.memory_mb = 30;  // so that 200 and 100 um fit, no more
  ASSERT_TRUE(ExplainScene(options_).ok());
  json::object facts = Facts();
  const json::object& picked = facts.at("picked").as_object();
  EXPECT_TRUE(picked.at("passive").as_bool());
  EXPECT_LE(picked.at("voxel_nm").as_int64(), 200'000);
  // The best of the front: nothing with a proof that fits its period is felt better.
  int on_front = 0;
  for (const json::value& v : facts.at("points").as_array()) {
    const json::object& p = v.as_object();
    on_front += p.at("on_front").as_bool();
    if (!p.at("passive").as_bool()) {
      EXPECT_FALSE(p.at("on_front").as_bool());
      continue;
    }
    const bool fits =
        p.at("runs").as_bool() && p.at("p99_us_95").as_array()[1].to_number<double>() <=
                                      1e6 / p.at("rate_hz").to_number<double>();
    if (fits) {
      EXPECT_GE(p.at("felt_error").as_double() + kSameError, picked.at("felt_error").as_double());
    }
  }
  EXPECT_GT(on_front, 0);
}

// What a scene changes is its bur's error by the voxel and the tick. With these and the hands of `qualify`, the best of
// the joint front is what `explain` picks.
TEST_F(ExplainTest, PicksTheBestOfTheJointFrontOnEveryScene) {
  QualifyOptions suite;
  suite.profile = options_.profile;
  suite.suites = {"front"};
  suite.quick = true;
  suite.json_path = folder_ / "front.json";
  ASSERT_EQ(RunQualify(suite), 0);
  std::map<std::string, double> hands;  // by law: those that can be picked
  const json::value found = json::parse(AsText(*ReadFile(suite.json_path)));
  for (const json::value& p : found.at("rows").as_array())
    if (p.at("passive").as_bool() && p.at("runs").as_bool())
      hands[std::string(p.at("law").as_string())] = p.at("hand_error").as_double();
  ASSERT_GE(hands.size(), 2u);
  options_.exercise.clear();
  options_.voxel_um = 100;
  options_.memory_mb = 60;  // no fine voxels: the ticks are not what is compared
  options_.budget_us = 1e5;
  const std::vector<std::string> all = scene::BuiltinSceneNames(), some = {"block", "incisor"};
  for (const std::string& scene : std::getenv("ENAMEL_FULL") != nullptr ? all : some) {
    options_.scene = "builtin:" + scene;
    EXPECT_TRUE(ExplainScene(options_).ok()) << scene;
    const json::object facts = Facts();
    std::map<int64_t, double> voxels;
    for (const json::value& p : facts.at("points").as_array())
      voxels[p.at("voxel_nm").as_int64()] = p.at("voxel_error").as_double();
    EXPECT_GE(voxels.size(), 2u) << scene;
    double least = 1;
    for (const auto& [law, hand] : hands)
      for (const auto& [nm, off] : voxels) least = std::min(least, std::hypot(hand, off));
    // A coarser voxel's tick is cheaper.
    std::string law;
    int64_t voxel_nm = 0;
    for (const auto& [name, hand] : hands)
      for (const auto& [nm, off] : voxels)
        if (std::hypot(hand, off) <= least + kSameError && nm > voxel_nm) law = name, voxel_nm = nm;
    const json::object& picked = facts.at("picked").as_object();
    EXPECT_EQ(picked.at("law").as_string(), law) << scene;
    EXPECT_EQ(picked.at("voxel_nm").as_int64(), voxel_nm) << scene;
    EXPECT_EQ(picked.at("hand_error").as_double(), hands[law]) << scene;
  }
}

TEST_F(ExplainTest, GradedWorkIsRefusedWhereItsBurIsTooSmallForTheVoxelAndPracticeIsNot) {
  options_.exercise = "class-1";
  const Status refused = ExplainScene(options_);
  EXPECT_EQ(refused.code(), Code::kInvalidInput);
  EXPECT_EQ(refused.field(), "voxel_um");
  EXPECT_NE(refused.message().find("is graded: voxels of 400 um are too coarse"), std::string::npos)
      << refused.message();
  EXPECT_EQ(Facts().at("voxel_verdict").as_string(), "refused");
  EXPECT_GT(Facts().at("voxel_force_error").as_double(), 0.1);
  options_.exercise = "line";
  EXPECT_TRUE(ExplainScene(options_).ok());
  EXPECT_EQ(Facts().at("voxel_verdict").as_string(), "warned");
}

TEST_F(ExplainTest, BudgetNothingCanKeepIsRefusedWithTheLeastMeasured) {
  options_.budget_us = 1e-3;
  Status refused = ExplainScene(options_);
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find("the least measured is"), std::string::npos);
}

TEST_F(ExplainTest, GradedExerciseThatTheMachineCannotCarryIsRefused) {
  options_.exercise = "class-1";
  options_.budget_us = 1e-3;
  Status refused = ExplainScene(options_);
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find("cannot carry"), std::string::npos) << refused.message();
  EXPECT_FALSE(Facts().at("fits").as_bool());
  EXPECT_TRUE(Facts().at("picked").is_null()) << "nothing keeps that, in practice neither";
}

TEST_F(ExplainTest, UnknownExerciseListsThoseOfTheScene) {
  options_.exercise = "class-9";
  Status refused = ExplainScene(options_);
  EXPECT_EQ(refused.code(), Code::kNotFound);
  EXPECT_NE(refused.message().find("line-block"), std::string::npos) << refused.message();
}

TEST_F(ExplainTest, VoxelTooSmallForTheMemoryIsRefusedWithOneThatFits) {
  options_.memory_mb = 1;
  options_.voxel_um = 50;
  Status refused = ExplainScene(options_);
  EXPECT_EQ(refused.code(), Code::kTooLarge);
  EXPECT_NE(refused.message().find("use voxels of at least"), std::string::npos);
}

}  // namespace
}  // namespace enamel::station::lab
