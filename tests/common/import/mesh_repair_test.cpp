#include "common/mesh/mesh_repair.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "shapes.h"

namespace enamel::import {
namespace {

TEST(MeshRepairTest, ClosedMeshNeedsNoRepair) {
  auto solid = mesh::MakeSolid(SphereMesh(5, 10));
  ASSERT_TRUE(solid.ok()) << solid.status().message();
  EXPECT_EQ(solid->report.open_edges, 0u);
  EXPECT_EQ(solid->report.flipped, 0u);
  EXPECT_EQ(solid->report.parts, 1u);
  EXPECT_EQ(solid->report.buried, 0u);
}

TEST(MeshRepairTest, TurnedTrianglesAreTurnedBackAndCounted) {
  mesh::Triangles m = SphereMesh(5, 10);
  double volume = mesh::SignedVolume(m);
  for (size_t i = 0; i < m.indices.size(); i += 3) std::swap(m.indices[i][0], m.indices[i][1]);
  auto solid = mesh::MakeSolid(m);
  ASSERT_TRUE(solid.ok());
  EXPECT_EQ(solid->report.flipped, (m.indices.size() + 2) / 3);
  EXPECT_NEAR(mesh::SignedVolume(solid->mesh), volume, 1e-9);
}

TEST(MeshRepairTest, InsideOutMeshIsTurned) {
  mesh::Triangles m = BoxMesh(dvec3(-3), dvec3(3));
  for (auto& t : m.indices) std::swap(t[0], t[1]);
  auto solid = mesh::MakeSolid(m);
  ASSERT_TRUE(solid.ok());
  EXPECT_EQ(solid->report.flipped, 12u);
  EXPECT_NEAR(mesh::SignedVolume(solid->mesh), 216, 1e-9);
}

TEST(MeshRepairTest, OpenBoxIsClosedByAFlatCap) {
  mesh::Triangles m = BoxMesh(dvec3(-3), dvec3(3));
  m.indices.erase(m.indices.begin(), m.indices.begin() + 2);  // its bottom
  auto solid = mesh::MakeSolid(m);
  ASSERT_TRUE(solid.ok()) << solid.status().message();
  EXPECT_EQ(solid->report.open_edges, 4u);
  EXPECT_EQ(solid->report.holes_closed, 1u);
  EXPECT_NEAR(mesh::SignedVolume(solid->mesh), 216, 1e-9);
}

TEST(MeshRepairTest, SheetIsRefusedWithTheReason) {
  mesh::Triangles m;
  m.vertices = {{0, 0, 0}, {5, 0, 0}, {5, 5, 0}, {0, 5, 0}, {2.5, 2.5, 0.1}};
  m.indices = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  auto solid = mesh::MakeSolid(m);
  ASSERT_FALSE(solid.ok());
  EXPECT_NE(solid.status().message().find("open sheet"), std::string::npos)
      << solid.status().message();
}

TEST(MeshRepairTest, MoebiusStripIsRefused) {
  mesh::Triangles m;
  const int n = 12;
  for (int i = 0; i < n; ++i) {
    double a = 2 * 3.14159265358979 * i / n, half = a / 2;
    for (double s : {-1.0, 1.0}) {
      double r = 5 + s * std::cos(half);
      m.vertices.emplace_back(r * std::cos(a), r * std::sin(a), s * std::sin(half));
    }
  }
  for (uint32_t i = 0; i < n; ++i) {
    uint32_t a = 2 * i, b = a + 1, c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? a + 3 : 0;
    m.indices.push_back({a, c, b});
    m.indices.push_back({b, c, d});
  }
  auto solid = mesh::MakeSolid(m);
  ASSERT_FALSE(solid.ok());
  EXPECT_NE(solid.status().message().find("one side"), std::string::npos)
      << solid.status().message();
}

TEST(MeshRepairTest, TrianglesInsideOverlappingPartsAreNoBoundary) {
  auto solid =
      mesh::MakeSolid(Joined(BoxMesh({-3, -3, -3}, {3, 3, 3}), BoxMesh({-1, -1, -1}, {1, 1, 1})));
  ASSERT_TRUE(solid.ok());
  EXPECT_EQ(solid->report.parts, 2u);
  EXPECT_EQ(solid->report.buried, 12u);
  EXPECT_EQ(solid->boundary.indices.size(), 12u);
}

TEST(MeshRepairTest, SameTriangleTwiceAndEmptyTrianglesAreLeftOut) {
  mesh::Triangles m = BoxMesh(dvec3(-3), dvec3(3));
  m.indices.push_back(m.indices[0]);
  m.indices.push_back({0, 0, 1});
  auto solid = mesh::MakeSolid(m);
  ASSERT_TRUE(solid.ok());
  EXPECT_EQ(solid->report.duplicate, 1u);
  EXPECT_EQ(solid->report.degenerate, 1u);
  EXPECT_EQ(solid->mesh.indices.size(), 12u);
}

}  // namespace
}  // namespace enamel::import
