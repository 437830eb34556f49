#include "common/mesh/solid_boundary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "common/mesh/mesh_repair.h"
#include "shapes.h"

namespace enamel::import {
namespace {

double AreaOf(const mesh::Triangles& mesh) {
  auto b = mesh::BoundaryOf(mesh, mesh::TriangleTree(mesh));
  EXPECT_TRUE(b.ok());
  return mesh::SurfaceArea(b->pieces);
}

TEST(SolidBoundaryTest, SurfaceThatCrossesNothingIsKeptAsItIs) {
  const mesh::Triangles sphere = SphereMesh(5, 20);
  auto b = mesh::BoundaryOf(sphere, mesh::TriangleTree(sphere));
  ASSERT_TRUE(b.ok());
  EXPECT_EQ(b->crossing, 0u);
  EXPECT_EQ(b->pieces.indices, sphere.indices);
}

// Noise larger than the triangles: the surface cannot be found.
TEST(SolidBoundaryTest, AScanThatCrossesItselfNearlyEverywhereIsRefused) {
  mesh::Triangles rough = SphereMesh(5, 40);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-0.6, 0.6);
  for (dvec3& vertex : rough.vertices) vertex += dvec3(noise(random), noise(random), noise(random));
  const auto b = mesh::BoundaryOf(rough, mesh::TriangleTree(rough));
  ASSERT_FALSE(b.ok());
  EXPECT_EQ(b.status().code(), Code::kInvalidInput);
  EXPECT_NE(b.status().message().find("smooth it"), std::string::npos) << b.status().message();
}

TEST(SolidBoundaryTest, AreaOfTwoSpheresThatOverlapIsThatOfTheirUnion) {
  // Radius 5, centres 6 apart: each loses a cap of height 2, area 2 pi r h.
  const double ideal = 2 * (4 * std::numbers::pi * 25 - 2 * std::numbers::pi * 5 * 2);
  const mesh::Triangles mesh = Joined(SphereMesh(5, 60), SphereMesh(5, 47, {6, 0, 0}));
  EXPECT_NEAR(AreaOf(mesh) / ideal, 1, 2e-3);
}

TEST(SolidBoundaryTest, LargeTrianglesAreCutWhereBoxesPassThroughEachOther) {
  // 6 x 2 x 2 bars crossed at right angles: 2 x 56 - 8 (walls within the other). Two 2 x 2 squares
  // of each in one plane count once and exist twice.
  const mesh::Triangles mesh =
      Joined(BoxMesh({-3, -1, -1}, {3, 1, 1}), BoxMesh({-1, -3, -1}, {1, 3, 1}));
  const double doubled = 2 * 4, ideal = 2 * 56 - 4 * 4 - doubled;
  EXPECT_NEAR(AreaOf(mesh), ideal + doubled, 0.3);
}

TEST(SolidBoundaryTest, WallBetweenTwoPartsThatTouchIsNoBoundary) {
  // A small box standing on a large one; both are kept apart by nothing.
  const mesh::Triangles mesh =
      Joined(BoxMesh({-3, -3, -3}, {3, 3, 0}), BoxMesh({-1, -1, 0}, {1, 1, 2}));
  EXPECT_NEAR(AreaOf(mesh), 2 * 36 + 4 * 18 - 4 + 4 * 4 + 4, 0.15);
}

TEST(SolidBoundaryTest, LoopOfASurfaceThatCrossesItselfCountsWhicheverWayAround) {
  // Bow tie prism: two triangles of base 4, height 3, turned opposite ways, 5 thick.
  mesh::Triangles m;
  for (double z : {0.0, 5.0})
    for (const dvec3& p : {dvec3(-3, -2, 0), dvec3(3, 2, 0), dvec3(3, -2, 0), dvec3(-3, 2, 0)})
      m.vertices.push_back(p + dvec3(0, 0, z));
  for (uint32_t i = 0; i < 4; ++i) {
    const uint32_t n = (i + 1) % 4;
    m.indices.push_back({i, n, i + 4});
    m.indices.push_back({n, n + 4, i + 4});
  }
  m.vertices.push_back({0, 0, 0});
  m.vertices.push_back({0, 0, 5});
  for (uint32_t i = 0; i < 4; ++i) {
    m.indices.push_back({(i + 1) % 4, i, 8});
    m.indices.push_back({i + 4, (i + 1) % 4 + 4, 9});
  }
  const mesh::TriangleTree tree(m);
  EXPECT_TRUE(tree.Inside({2, 0, 2.5}));
  EXPECT_TRUE(tree.Inside({-2, 0, 2.5}));
  EXPECT_FALSE(tree.Inside({0, 1.5, 2.5}));
}

TEST(SolidBoundaryTest, ThousandsOfBoxesThroughEachOtherAreRefusedInBoundedWork) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 2);
  mesh::Triangles soup;
  for (int i = 0; i < 4000; ++i) {
    const dvec3 at(uniform(random), uniform(random), uniform(random));
    const mesh::Triangles box = BoxMesh(at, at + 3.0);
    const auto first = static_cast<uint32_t>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), box.vertices.begin(), box.vertices.end());
    for (const auto& t : box.indices)
      soup.indices.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  auto solid = mesh::MakeSolid(soup);
  ASSERT_FALSE(solid.ok());
  EXPECT_NE(solid.status().message().find("soup"), std::string::npos) << solid.status().message();
}

}  // namespace
}  // namespace enamel::import
