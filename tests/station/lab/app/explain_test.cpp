#include "station/lab/app/explain.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/json.hpp>
#include <filesystem>
#include <set>

#include "common/base/file.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/plan.h"
#include "station/lab/cutting/scene_cost.h"

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
  EXPECT_EQ(names.size(), 12u);
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
  EXPECT_TRUE(kept.at("ns_per_tick").is_double());
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

TEST_F(ExplainTest, PracticeWithAGenerousBudgetPicksTheFinestVoxelAndAPassiveLaw) {
  options_.budget_us = 1e5;
  options_.memory_mb = 30;  // so that 200 and 100 um fit, no more
  ASSERT_TRUE(ExplainScene(options_).ok());
  json::object facts = Facts();
  const json::array& voxels = facts.at("voxels").as_array();
  ASSERT_GE(voxels.size(), 1u);
  const json::object& picked = facts.at("picked").as_object();
  // The finest that also fits into the period of a tick.
  EXPECT_LE(picked.at("voxel_nm").as_int64(), 200'000);
  for (const json::value& l : facts.at("laws").as_array()) {
    if (l.at("law") == picked.at("law")) {
      EXPECT_TRUE(l.at("passive").as_bool());
    }
  }
}

TEST_F(ExplainTest, BudgetNothingCanKeepIsRefusedWithTheLeastMeasured) {
  options_.budget_us = 1e-3;
  Status refused = ExplainScene(options_);
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find("the least measured is"), std::string::npos);
}

TEST_F(ExplainTest, GradedExerciseThatTheMachineCannotCarryIsRefusedAndNothingIsPicked) {
  options_.exercise = "class-1";
  options_.budget_us = 1e-3;
  Status refused = ExplainScene(options_);
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find("cannot carry"), std::string::npos) << refused.message();
  EXPECT_FALSE(Facts().at("fits").as_bool());
  EXPECT_FALSE(Facts().contains("picked"));
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

TEST(SceneCostTest, ForceOfThePassiveLawsIsThatOfEquationOneInAStraightSlot) {
  auto built = scene::BuildBuiltinScene("block", 400'000);
  ASSERT_TRUE(built.ok());
  scene::Exercise e = scene::ClassOneExercise(built->scene, {});
  for (auto law : {haptics::LawKind::kMaxwell, haptics::LawKind::kLeadMaxwell}) {
    e.law = law;
    auto params = scene::CompilePlan(built->scene, e, scene::BuiltinProfiles()[1]);
    ASSERT_TRUE(params.ok());
    // 2.8 N to within 3 %.
    EXPECT_LT(ForceError_n(*params), 0.08);
  }
}

}  // namespace
}  // namespace enamel::station::lab
