#include "station/lab/grades/mixtures.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <utility>

// Faults of shapes that the explanation's dictionary does not contain, in every exercise. The witness is
// our own: the test reads the volumes anew and knows where each fault was cut.
namespace enamel::station::lab {
namespace {

double Number(const boost::json::object& document, const char* name) {
  return document.at(name).to_number<double>();
}

// One mixture of each kind of task. ENAMEL_FULL=1 tries all exercises in turn; `enamel-lab grades --mixtures` tries
// thousands.
MixturesOptions Asked() {
  if (std::getenv("ENAMEL_FULL") != nullptr) return {.count = 64, .seed = 1};
  return {
      .count = 14,
      .seed = 1,
      .exercises = {"access-premolar", "caries-molar-46-caries-deep", "class-1-primary", "class-2-",
                    "class-5-", "crown-incisor", "crown-molar-46-class-2", "fissures-molar-46",
                    "mod-", "pulpotomy-", "trapezoid-", "veneer-", "step-block", "circle-block"}};
}

TEST(MixturesTest, BreakNoLawAndAreNamed) {
  const auto rows = TryMixtures(Asked());
  ASSERT_TRUE(rows.ok()) << rows.status().message();
  ASSERT_EQ(rows->size(), static_cast<size_t>(Asked().count));
  for (const MixtureRow& row : *rows) {
    EXPECT_TRUE(row.wrong.empty()) << row.exercise << ": " << row.wrong.front();
    EXPECT_TRUE(row.broken.empty())
        << row.exercise << ", seed " << row.seed << ": " << row.broken.front();
    EXPECT_EQ(row.larger.size(), row.faults.size());
  }
  const auto document = MixturesJson(*rows);
  EXPECT_EQ(document.at("laws_broken"), 0);
  EXPECT_GT(Number(document, "sentences"), 10 * Asked().count);
  EXPECT_EQ(document.at("sentences_false"), 0);
  EXPECT_GT(Number(document, "faults_asked"), Asked().count);
  EXPECT_GE(Number(document, "faults_found"), 0.92 * Number(document, "faults_asked"));
  EXPECT_LE(Number(document, "mistakes_invented"), 0.03 * Number(document, "mistakes"));
  EXPECT_LE(Number(document, "uneven_share"), 0.05);
  std::ifstream file(ENAMEL_SOURCE_DIR "/schemas/lab_mixtures.schema.json");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const auto schema = boost::json::parse(text);
  for (const auto& name : schema.at("required").as_array()) {
    EXPECT_TRUE(document.contains(name.as_string())) << name;
  }
}

TEST(MixturesTest, AnUnknownExerciseIsRefused) {
  EXPECT_EQ(TryMixtures({.exercises = {"bridge"}}).status().code(), Code::kNotFound);
}

// The same faults at other places of a grid of 0.1 mm: pits beside line angles and between two walls; a groove in a cut
// that meets the pulp, which some places open and others do not.
TEST(MixturesTest, PartsOfAVoxelMoveAScoreLittle) {
  const MixturesOptions cases[] = {
      {.count = 1, .offsets = 8, .seed = 26, .exercises = {"circle-block"}},
      {.count = 1, .offsets = 2, .seed = 5002, .exercises = {"access-molar"}}};
  for (const MixturesOptions& options : cases) {
    const auto rows = TryMixtures(options);
    ASSERT_TRUE(rows.ok()) << rows.status().message();
    EXPECT_GT(rows->front().offset_spread, 0) << options.exercises[0];
    EXPECT_LT(rows->front().offset_spread, 0.8) << options.exercises[0];
  }
}

}  // namespace
}  // namespace enamel::station::lab
