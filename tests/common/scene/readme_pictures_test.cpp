#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "common/base/sha256.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"

// The pictures of a score in README.md and the guides show the rubric of today.
namespace enamel::scene {
namespace {

namespace json = boost::json;

const std::filesystem::path kPictures = std::filesystem::path(ENAMEL_SOURCE_DIR) / "web/pictures";
constexpr const char* kMend = "make the pictures again with web/pictures/make";

// The rubric of the exercise that the pictures show.
Rubric RubricOfToday() {
  const auto built = BuildBuiltinScene("molar", 200'000);
  if (!built.ok()) return {};
  for (const Exercise& e : BuiltinExercises(built->scene, Sha256{})) {
    if (e.name == "class-1-molar-46") return e.rubric;
  }
  return {};
}

// What web/pictures/make wrote about a picture, as shown.json has it.
json::object Shown(const std::string& picture) {
  const auto text = ReadFile(kPictures / "shown.json");
  if (!text.ok()) return {};
  const json::value pictures = json::parse(AsText(*text));
  for (const json::value& one : pictures.as_array()) {
    if (one.at("picture").as_string() == picture) return one.as_object();
  }
  return {};
}

class ReadmePicturesTest : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Scores, ReadmePicturesTest,
                         testing::Values("attempt.png", "exam_attempt.webp", "exam_grades.webp",
                                         "exam_grading.webp", "station_score.png"),
                         [](const auto& picture) {
                           return std::filesystem::path(picture.param).stem().string();
                         });

TEST_P(ReadmePicturesTest, ShowTheRubricOfToday) {
  const json::object shown = Shown(GetParam());
  ASSERT_FALSE(shown.empty()) << "shown.json says nothing about it: " << kMend;
  const Rubric today = RubricOfToday();
  const json::value& rubric = shown.at("rubric");
  EXPECT_EQ(rubric.at("name").as_string(), today.name) << kMend;
  EXPECT_EQ(rubric.at("version").to_number<int>(), today.version) << kMend;
  EXPECT_EQ(rubric.at("sha256").as_string(), HashSha256(AsBytes(ToJson(today))).Hex()) << kMend;
}

TEST_P(ReadmePicturesTest, AreThoseThatTheCommandMade) {
  const json::object shown = Shown(GetParam());
  ASSERT_FALSE(shown.empty()) << "shown.json says nothing about it: " << kMend;
  const auto png = ReadFile(kPictures / GetParam());
  ASSERT_TRUE(png.ok()) << png.status().message();
  EXPECT_EQ(shown.at("sha256").as_string(), HashSha256(*png).Hex()) << kMend;
}

}  // namespace
}  // namespace enamel::scene
