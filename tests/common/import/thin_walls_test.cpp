#include "common/import/thin_walls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/import/import_tooth.h"
#include "common/scene/builder.h"
#include "common/surface/surface.h"
#include "tests/common/import/report_lines.h"
#include "tests/common/import/shapes.h"

namespace enamel::import {
namespace {

// A plate across x, its thickness as the mesh of its voxels has it, 0 where it is left out. `at`: where the grid
// lies, in voxels.
double MeasuredThickness_mm(double thickness_mm, double voxel_mm, double at) {
  const double t = thickness_mm * 1e-3;
  auto field = [t](const dvec3& p) {
    return scene::FieldSample{std::abs(p.x) - t / 2, cutting::Tissue::kGypsum, 1.0};
  };
  cutting::GridSpec grid = scene::GridAround(dvec3(-0.5e-3), dvec3(0.5e-3),
                                             static_cast<int32_t>(std::lround(voxel_mm * 1e6)));
  // A sample at x = 0, then moved.
  const auto voxel_nm = int64_t{grid.voxel_nm};
  grid.origin_nm[0] =
      grid.origin_nm[0] / voxel_nm * voxel_nm + std::llround(at * static_cast<double>(voxel_nm));
  const cutting::Volume v = scene::BuildVolume(grid, scene::Field(field), 1);
  const surface::Mesh mesh = surface::ExtractSurface(v);
  double least = 1e9, most = -1e9;
  for (const auto& p : mesh.position_m) {
    if (std::abs(p.y) > 0.2e-3F || std::abs(p.z) > 0.2e-3F) continue;
    least = std::min(least, static_cast<double>(p.x));
    most = std::max(most, static_cast<double>(p.x));
  }
  return most > least ? (most - least) * 1e3 : 0;
}

TEST(ThinWallsTest, TwoVoxelsAreKeptWhereverTheGridLiesAndOneIsNot) {
  for (double at : {0.0, 0.125, 0.25, 0.4, 0.5, 0.8})
    EXPECT_NEAR(MeasuredThickness_mm(0.2, 0.1, at), 0.2, 1e-3) << at;
  // A sample in the middle; a quarter of a voxel from it; both faces on samples.
  EXPECT_NEAR(MeasuredThickness_mm(0.1, 0.1, 0), 0.100, 1e-3);
  EXPECT_NEAR(MeasuredThickness_mm(0.1, 0.1, 0.25), 0.075, 1e-3);
  EXPECT_LT(MeasuredThickness_mm(0.1, 0.1, 0.5), 1e-3);
}

std::optional<ThinWalls> ThinOf(const mesh::Triangles& mesh, double limit_mm) {
  const mesh::TriangleTree tree(mesh);
  return FindThinWalls(
      tree, [&](const dvec3& p) { return tree.Inside(p); }, limit_mm);
}

TEST(ThinWallsTest, APlateIsMeasuredAndAThickerOneIsNot) {
  const auto plate = ThinOf(BoxMesh({0, 0, 0}, {6, 6, 0.15}), 0.2);
  ASSERT_TRUE(plate);
  EXPECT_NEAR(plate->least_mm, 0.15, 0.001);
  EXPECT_NEAR(plate->area_mm2, 72, 4);  // both faces; near its edges the sides are as near
  EXPECT_FALSE(ThinOf(BoxMesh({0, 0, 0}, {6, 6, 0.25}), 0.2));
  EXPECT_FALSE(ThinOf(SphereMesh(4, 40), 0.2));
}

TEST(ThinWallsTest, ImportWarnsWithThePlaceAndTheVoxelThatWouldDo) {
  // A fin on a block.
  const mesh::Triangles fin =
      Joined(BoxMesh({-4, -4, 0}, {4, 4, 6}), BoxMesh({-0.075, -3, 5}, {0.075, 3, 8}));
  ImportOptions options;
  options.tooth = 36;
  options.up = "+z";
  options.buccal = "+y";
  options.voxel_nm = 100'000;
  auto scene = ImportTriangles(fin, "test", options);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  const std::string text = Lines(*scene);
  EXPECT_NE(text.find("warning: walls thinner than two voxels (0.20 mm)"), std::string::npos)
      << text;
  EXPECT_NE(text.find("voxels of 7"), std::string::npos) << text;
  EXPECT_NE(text.find(" um would carry them"), std::string::npos) << text;
  options.voxel_nm = 50'000;
  scene = ImportTriangles(fin, "test", options);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(Lines(*scene).find("warning"), std::string::npos) << Lines(*scene);
}

}  // namespace
}  // namespace enamel::import
