#include "station/lab/grades/operators.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>
#include <iterator>
#include <set>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "station/devices/operators.h"

namespace enamel::station::lab {
namespace {

TEST(OperatorsTest, SpearmanIsThatOfTheTextbook) {
  // 1 - 6 sum d^2 / (n (n^2 - 1)) with d = 1, -1, 1, -1, 0 and n = 5.
  EXPECT_NEAR(Spearman({1, 2, 3, 4, 5}, {20, 10, 40, 30, 50}), 0.8, 1e-12);
  EXPECT_NEAR(Spearman({1, 2, 3}, {9, 5, 1}), -1, 1e-12);
  // Ties share their mean rank: of 1.5, 1.5, 3 and 1, 2, 3 it is the square root of 3/4.
  EXPECT_NEAR(Spearman({7, 7, 9}, {1, 2, 3}), 0.8660254037844387, 1e-12);
  EXPECT_EQ(Spearman({4, 4}, {1, 2}), 0);
  EXPECT_EQ(Spearman({}, {}), 0);
}

TEST(OperatorsTest, EqualSkillComparesTheMeansOfTheSameSeeds) {
  auto row = [](const char* device, const char* name, uint64_t seed, double score) {
    return OperatorRow{"box", device, name, 5, seed, score == 0, score};
  };
  const auto found =
      EqualSkillOf({row("a", "good", 1, 90), row("a", "good", 2, 96), row("a", "good", 3, 0),
                    row("b", "good", 1, 93), row("b", "good", 2, 92), row("b", "good", 3, 10),
                    row("a", "hasty", 1, 0), row("b", "hasty", 1, 70)});
  // Seed 3 failed critically on one device; hasty has no seed left.
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].name, "good");
  EXPECT_EQ(found[0].seeds, 2u);
  EXPECT_NEAR(found[0].points, 0.5, 1e-12);  // 93 and 92.5
  EXPECT_TRUE(EqualSkillOf({row("a", "good", 1, 90), row("a", "good", 2, 80)}).empty());
}

TEST(OperatorsTest, FullMarksAreCountedOfOnePersonAlone) {
  auto row = [](const char* name, double score) {
    return OperatorRow{"box", "a", name, 5, 1, false, score};
  };
  const FullMarks found = FullMarksOf(
      {row("student", 100), row("student", 99.99), row("student", 0), row("dentist", 100)},
      "student");
  EXPECT_EQ(found.full, 1u);
  EXPECT_EQ(found.rows, 3u);
}

TEST(OperatorsTest, TheDocumentIsTheSchemas) {
  OperatorsFindings findings;
  findings.rows = {{"class-1-x", "omega3", "hasty", 5, 12, false, 71.5}};
  findings.order = {{"class-1-x", "omega3", 1, 0}};
  findings.equal_skill = {{"class-1-x", "hasty", 2, 0.5}};
  findings.not_cut = {"crown-x"};
  findings.left_out = {{"cross-x", "omega3", "undercutter"}};
  std::ifstream file(ENAMEL_SOURCE_DIR "/schemas/golden/lab_operators.json");
  const std::string golden(std::istreambuf_iterator<char>(file), {});
  EXPECT_EQ(boost::json::value(OperatorsJson(findings)), boost::json::parse(golden));
}

TEST(OperatorsTest, EightPeopleHaveTheEightRanks) {
  std::set<int> ranks;
  for (const OperatorPreset& preset : OperatorPresets())
    if (preset.rank != 0) EXPECT_TRUE(ranks.insert(preset.rank).second) << preset.name;
  EXPECT_EQ(ranks, (std::set<int>{1, 2, 3, 4, 5, 6, 7, kFullSkill}));
}

// Walls cut in beyond their middle leave nothing to go round: must not crash.
TEST(OperatorsTest, EverybodyHasAPlanForACrownOrSaysWhyNot) {
  const auto built = scene::BuildBuiltinScene("molar-caries", 400'000);
  ASSERT_TRUE(built.ok());
  const scene::DeviceProfile profile = scene::BuiltinProfiles().front();
  size_t crowns = 0;
  for (const scene::Exercise& e :
       scene::BuiltinExercises(built->scene, HashSha256(AsBytes(scene::ToJson(built->scene))))) {
    if (!e.name.starts_with("crown")) continue;
    ++crowns;
    const auto params = scene::CompilePlan(built->scene, e, profile);
    ASSERT_TRUE(params.ok()) << params.status().message();
    for (const OperatorPreset& preset : OperatorPresets()) {
      const auto device =
          MakeSimulatedDevice(preset, built->scene, e, profile, *params, built->volume);
      EXPECT_TRUE(device.ok() || !device.status().message().empty()) << preset.name;
    }
  }
  EXPECT_GT(crowns, 0u);
}

TEST(OperatorsTest, ADeviceThatIsNotThereIsRefusedByName) {
  OperatorsOptions options;
  options.devices = {"spoon"};
  const auto findings = MeasureOperators(options);
  ASSERT_FALSE(findings.ok());
  EXPECT_EQ(findings.status().code(), Code::kNotFound);
  EXPECT_NE(findings.status().message().find("spoon"), std::string::npos);
}

TEST(OperatorsTest, APersonWithoutARankIsRefusedByName) {
  OperatorsOptions options;
  options.operators = {"student", "clumsy"};
  const auto findings = MeasureOperators(options);
  ASSERT_FALSE(findings.ok());
  EXPECT_EQ(findings.status().code(), Code::kNotFound);
  EXPECT_EQ(findings.status().field(), "operator");
}

}  // namespace
}  // namespace enamel::station::lab
