#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/profile_criteria.h"

// An exercise's text fits its tooth, and its numbers are its target's.
namespace enamel::scene {
namespace {

using cutting::Tissue;

std::string WordsOf(const Exercise& e) {
  std::string out = e.title + " " + e.instructions;
  for (const RubricCriterion& c : e.rubric.criteria) out += " " + c.title + " " + c.comment;
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

bool Has(const Scene& scene, Tissue tissue) {
  return std::any_of(scene.tissues.begin(), scene.tissues.end(),
                     [&](const TissueSpec& t) { return t.tissue == tissue; });
}

void ExpectNone(const std::string& words, const std::vector<const char*>& of, const char* why) {
  for (const char* word : of) {
    EXPECT_EQ(words.find(word), std::string::npos)
        << "\"" << word << "\" where there is no " << why;
  }
}

class WordsTest : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Scenes, WordsTest, testing::ValuesIn(BuiltinSceneNames()),
                         [](const auto& scene) {
                           std::string name = scene.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST_P(WordsTest, FitTheScene) {
  auto built = BuildBuiltinScene(GetParam(), 200'000);
  ASSERT_TRUE(built.ok());
  for (const Exercise& e : BuiltinExercises(built->scene, {})) {
    SCOPED_TRACE(e.name);
    const std::string words = WordsOf(e);
    if (!Has(built->scene, Tissue::kNeighbour)) ExpectNone(words, {"neighbour"}, "neighbour");
    if (!Has(built->scene, Tissue::kCaries)) ExpectNone(words, {"caries", "lesion"}, "caries");
    if (!Has(built->scene, Tissue::kPulp)) {
      ExpectNone(words, {"pulp", "dentin", "enamel", "fossa", "occlusal", "cusp", "tooth"},
                 "tooth");
    }
    if (built->scene.name.starts_with("incisor")) {
      ExpectNone(words, {"occlusal", "cusp", "fossa", "marginal ridge"}, "chewing surface");
      EXPECT_NE(words.find("incisal"), std::string::npos);
    }
  }
}

std::string Mm(int32_t um) {
  std::string text =
      std::to_string(um / 1000) + "." + std::to_string(um / 10 % 100 + 100).substr(1);
  if (text.back() == '0') text.pop_back();
  return text + " mm";
}

// One tolerance: what the text promises and the zones are drawn with.
TEST_P(WordsTest, OfACavityAreItsTargetsNumbers) {
  auto built = BuildBuiltinScene(GetParam(), 200'000);
  ASSERT_TRUE(built.ok());
  for (const Exercise& e : BuiltinExercises(built->scene, {})) {
    if (!e.name.starts_with("class-1")) continue;
    SCOPED_TRACE(e.instructions);
    const CavityTarget& t = e.target;
    for (int32_t um :
         {2 * t.half_size_um[0], 2 * t.half_size_um[1], t.depth_um, t.leeway_side_um}) {
      EXPECT_NE(e.instructions.find(Mm(um)), std::string::npos) << Mm(um);
    }
    EXPECT_EQ(t.leeway_side_um, t.leeway_bottom_um);
  }
}

TEST(WordsTest, OfACrownAreItsStumpsNumbers) {
  for (const char* name : {"molar", "premolar", "incisor"}) {
    auto built = BuildBuiltinScene(name, 200'000);
    ASSERT_TRUE(built.ok());
    for (const Exercise& e : BuiltinExercises(built->scene, {})) {
      if (!e.name.starts_with("crown")) continue;
      ASSERT_EQ(e.target.parts.size(), 1u);
      const PreparationPart& part = e.target.parts[0];
      EXPECT_EQ(part.outline, PreparationPart::Outline::kStump);
      for (int32_t um : {part.depth_um, part.stump.table_below_um}) {
        EXPECT_NE(e.instructions.find(Mm(um)), std::string::npos) << e.instructions;
      }
    }
  }
}

// For every built-in tooth, for scans of the same teeth with known landmarks only, and for a
// prepared tooth.
std::vector<Exercise> EveryKindOfExercise() {
  std::vector<Exercise> out;
  for (const std::string& name : BuiltinSceneNames()) {
    auto built = BuildBuiltinScene(name, 200'000);
    if (!built.ok()) continue;
    std::ranges::copy(BuiltinExercises(built->scene, {}), std::back_inserter(out));
    Scene scan = built->scene;
    scan.name = scan.name.starts_with("incisor") ? "incisor-of-a-scan" : "scan";
    std::ranges::copy(BuiltinExercises(scan, {}), std::back_inserter(out));
    if (scan.landmarks.contains("occlusal_centre")) {
      out.push_back(PreparedExercise(built->scene, {}, {}));
    }
  }
  return out;
}

// Where each number of a profile comes from.
std::vector<std::string> SourcesOf(const DeviceProfile& profile) {
  const std::string json = ToJson(profile);
  static const std::regex kSource(R"re("source": *"([^"]+)")re");
  std::vector<std::string> out;
  for (std::sregex_iterator at(json.begin(), json.end(), kSource), end; at != end; ++at) {
    out.push_back((*at)[1]);
  }
  return out;
}

// The page says all of these in the languages it has (schemas/words.md), by the golden file.
TEST(WordsTest, ThatAreBuiltInAreThoseOfTheGoldenFile) {
  std::set<std::string> lines;
  for (const Exercise& e : EveryKindOfExercise()) {
    lines.insert("title " + e.title);
    lines.insert("text " + e.instructions);
    for (const RubricCriterion& c : e.rubric.criteria) {
      lines.insert({"title " + c.title, "text " + c.comment});
    }
    // Beside the grade of a category.
    for (const RubricCritical& c : e.rubric.critical)
      if (!c.source.starts_with("chosen")) lines.insert("title " + c.source);
  }
  for (DeviceProfile profile : BuiltinProfiles()) {
    for (const std::string& source : SourcesOf(profile)) lines.insert("title " + source);
    // Others have the names of products.
    if (profile.name == "pointer") lines.insert("title " + profile.title);
    profile.structural_mode_hz = {100, "test"};  // has a criterion of its own
    for (const ProfileCriterion& c : CheckProfile(profile)) lines.insert("title " + c.title);
  }
  for (const BuiltinScene& scene : BuiltinScenes()) {
    auto built = BuildBuiltinScene(scene.name, 200'000);
    ASSERT_TRUE(built.ok());
    lines.insert("title " + built->scene.title);
    lines.insert("title " + std::string(scene.summary));
  }
  std::string words;
  for (const std::string& line : lines) words += line + "\n";
  auto golden =
      ReadFile(std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas/golden/builtin_words.txt");
  ASSERT_TRUE(golden.ok()) << golden.status().message();
  EXPECT_EQ(words, std::string(golden->begin(), golden->end()));
}

}  // namespace
}  // namespace enamel::scene
