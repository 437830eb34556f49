#include "common/scoring/fine_bands.h"

#include <gtest/gtest.h>

#include "common/scene/builtin/builtin.h"
#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

scene::Rubric With(const std::string& metric, const std::string& unit,
                   std::vector<scene::RubricPoint> map) {
  scene::Rubric out;
  out.criteria.push_back({metric, "A criterion", unit, 10, std::move(map), "", {}});
  return out;
}

TEST(FineBandsTest, BandFinerThanAQuarterVoxelIsFoundAndAWiderOneIsNot) {
  const scene::Rubric fine = With("wall_mesial_mm", "mm", {{0, 1}, {0.1, 1}, {0.12, 0}});
  const auto found = FineBands(fine, 100'000);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].metric, "wall_mesial_mm");
  EXPECT_NEAR(found[0].band, 0.02, 1e-12);
  EXPECT_NEAR(found[0].error, 0.025, 1e-12);
  EXPECT_TRUE(FineBands(fine, 50'000).empty()) << "known twice as well";
  EXPECT_TRUE(FineBands(With("wall_mesial_mm", "mm", {{0.1, 1}, {0.2, 0}}), 100'000).empty());
}

TEST(FineBandsTest, OfAMaterialTheMapsThatCountAreLookedAt) {
  scene::Rubric rubric = With("undercut_deg", "deg", {{2, 1}, {8, 0}});
  rubric.restoration = scene::Restoration::kCeramic;
  rubric.restorations = {
      {scene::Restoration::kCeramic, "x", {}, {{"undercut_deg", {{0.5, 1}, {0.6, 0}}}}, {}}};
  EXPECT_EQ(FineBands(rubric, 50'000).size(), 1u);
  rubric.restoration = scene::Restoration::kNone;
  EXPECT_TRUE(FineBands(rubric, 50'000).empty());
}

TEST(FineBandsTest, FlatStretchesDoNotCount) {
  EXPECT_TRUE(FineBands(With("floor_mm", "mm", {{0, 1}, {0.001, 1}, {0.3, 0}}), 100'000).empty());
}

TEST(FineBandsTest, AnglesAreKnownToHalfADegreeAndOutlinesToAVoxel) {
  EXPECT_EQ(FineBands(With("undercut_deg", "deg", {{2, 1}, {2.4, 0}}), 50'000).size(), 1u);
  EXPECT_TRUE(FineBands(With("undercut_deg", "deg", {{2, 1}, {4, 0}}), 50'000).empty());
  const scene::Rubric outline = With("outline_over_mm", "mm", {{0.1, 1}, {0.17, 0}});
  EXPECT_EQ(FineBands(outline, 100'000).size(), 1u);
  EXPECT_TRUE(FineBands(outline, 50'000).empty());
}

TEST(FineBandsTest, VolumesForcesAndWaysAreLeftOut) {
  EXPECT_TRUE(FineBands(With("overcut_mm3", "mm3", {{0, 1}, {0.001, 0}}), 100'000).empty());
  EXPECT_TRUE(FineBands(With("force_sent_p95_n", "N", {{1, 1}, {1.001, 0}}), 100'000).empty());
  EXPECT_TRUE(FineBands(With("path_length_mm", "mm", {{1, 1}, {1.001, 0}}), 100'000).empty());
}

TEST(FineBandsTest, TextSaysBothFiguresAndWhatToDo) {
  EXPECT_EQ(FineBandText({"wall_mesial_mm", "mm", 0.02, 0.025}, 100'000),
            "wall_mesial_mm: points change within 0.02 mm, and it is known to 0.025 mm at voxels "
            "of 0.1 mm; differences in between score by chance. Make the band wider");
}

TEST(FineBandsTest, BuiltInRubricsAskForNothingFinerThanTheirOwnVoxels) {
  for (const std::string& name : scene::BuiltinSceneNames()) {
    const auto built = scene::BuildBuiltinScene(name, 200'000);
    ASSERT_TRUE(built.ok());
    for (const scene::Exercise& e : scene::BuiltinExercises(built->scene, {})) {
      for (const FineBand& band : FineBands(e.rubric, 50'000)) {
        ADD_FAILURE() << e.name << ": " << FineBandText(band, 50'000);
      }
    }
  }
}

}  // namespace
}  // namespace enamel::scoring
