#include "station/desk/result_pictures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <string>

#include "common/base/file.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/preparation.h"
#include "common/timeline/deviation.h"
#include "station/render/materials.h"
#include "tests/support/analytic_volume.h"

namespace enamel::station::desk {
namespace {

TEST(DeviationScaleTest, HasThePagesColoursAndRange) {
  const auto text =
      ReadFile(std::filesystem::path(ENAMEL_SOURCE_DIR) / "web/src/tooth/deviation_scale.ts");
  ASSERT_TRUE(text.ok());
  const std::string source(AsText(*text));
  std::vector<uint32_t> colours;
  const std::regex hex("\"#([0-9a-f]{6})\"");
  for (std::sregex_iterator it(source.begin(), source.end(), hex), end; it != end; ++it) {
    colours.push_back(static_cast<uint32_t>(std::stoul((*it)[1].str(), nullptr, 16)));
  }
  ASSERT_EQ(colours.size(), static_cast<size_t>(render::kDeviationSteps) + 1);
  // The page names the untouched one first.
  std::rotate(colours.begin(), colours.begin() + 1, colours.end());
  for (int i = 0; i <= render::kDeviationSteps; ++i) {
    EXPECT_EQ(render::DeviationColour(i), colours[static_cast<size_t>(i)]) << i;
  }
  std::smatch range;
  ASSERT_TRUE(std::regex_search(source, range, std::regex("kDeviationRangeMm = ([0-9.]+);")));
  EXPECT_EQ(std::stod(range[1].str()), render::kDeviationRange_mm);
  EXPECT_EQ(render::DeviationMaterial(0), render::kDeviationSteps / 2);
  EXPECT_EQ(render::DeviationMaterial(-0.5), 0);
  EXPECT_EQ(render::DeviationMaterial(9), render::kDeviationSteps - 1);
  EXPECT_EQ(render::DeviationMaterial(0.26), 8) << "the nearest tenth";
}

TEST(ResultPicturesTest, EveryComparedVertexHasTheColourOfItsCell) {
  cutting::GridSpec spec;
  spec.voxel_nm = 50'000;
  spec.bricks = ivec3(6);
  spec.origin_nm = {-1'200'000, -1'170'000, -1'190'000};
  const cutting::Volume ball = test::VolumeOf(
      spec, cutting::Tissue::kEnamel, [](const dvec3& p) { return glm::length(p) - 0.9e-3; });
  std::vector<ivec3> cells;
  const surface::Mesh mesh = surface::ExtractSurface(ball, &cells);
  timeline::Deviation deviation;
  deviation.spec = ball.spec();
  auto is_compared = [](const ivec3& cell) { return cell.z > 30; };
  size_t compared = 0;
  for (const ivec3& cell : cells) {
    if (!is_compared(cell)) continue;
    ++compared;
    deviation.cells.push_back({cell, -290});
  }
  ASSERT_GT(compared, 100u);
  const auto painted = DeviationSurface(mesh, cells, timeline::EncodeDeviation(deviation));
  ASSERT_TRUE(painted.ok()) << painted.status().message();
  ASSERT_EQ(painted->vertices.size(), mesh.position_m.size());
  size_t wrong = 0;
  for (size_t i = 0; i < cells.size(); ++i) {
    wrong += painted->vertices[i].tissue != (is_compared(cells[i]) ? 2 : render::kUntouched);
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(DeviationSurface(mesh, cells, AsBytes("no deviation")).status().code(),
            Code::kInvalidInput);
}

TEST(ResultPicturesTest, TheTargetIsTheToothWithItsCavity) {
  auto built = scene::BuildBuiltinScene("block", 200'000);
  ASSERT_TRUE(built.ok());
  PreparedAttempt prepared;
  prepared.scene = built->scene;
  prepared.volume = built->volume;
  prepared.exercise = scene::ClassOneExercise(built->scene, {});
  const scene::CavityTarget& target = prepared.exercise.target;
  const auto at = scene::TargetPoint(prepared.scene, target);
  ASSERT_TRUE(at.ok());
  const dvec3 top_mm = dvec3((*at)[0], (*at)[1], (*at)[2]) * 1e-3;
  const double depth_mm = 1e-3 * target.depth_um;
  auto floor_vertices = [&](const render::GroupMesh& mesh) {
    return std::ranges::count_if(mesh.vertices, [&](const render::GpuVertex& v) {
      return std::abs(v.position_mm[0] - top_mm.x) < 0.5 &&
             std::abs(v.position_mm[1] - top_mm.y) < 0.5 &&
             std::abs(v.position_mm[2] - (top_mm.z - depth_mm)) < 0.2;
    });
  };
  EXPECT_GT(floor_vertices(TargetSurface(prepared)), 0);
  prepared.exercise.target.depth_um = 0;
  EXPECT_TRUE(TargetSurface(prepared).indices.empty());
}

}  // namespace
}  // namespace enamel::station::desk
