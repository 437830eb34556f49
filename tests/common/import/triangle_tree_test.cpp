#include "common/mesh/triangle_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "shapes.h"

namespace enamel::import {
namespace {

TEST(TriangleTreeTest, DistanceToABoxIsTheClosedForm) {
  mesh::TriangleTree tree(BoxMesh({-1, -2, -3}, {1, 2, 3}));
  EXPECT_NEAR(tree.Distance({4, 0, 0}, 100), 3, 1e-12);
  EXPECT_NEAR(tree.Distance({4, 6, 0}, 100), 5, 1e-12);
  EXPECT_NEAR(tree.Distance({2, 3, 4}, 100), std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(tree.Distance({0, 0, 0}, 100), 1, 1e-12);
  EXPECT_EQ(tree.Distance({4, 0, 0}, 2), 2);
}

TEST(TriangleTreeTest, WindingIsOneInsideAndZeroOutside) {
  mesh::TriangleTree tree(SphereMesh(5, 40));
  for (double x = -9.9; x < 10; x += 0.73)
    for (double y = -9.9; y < 10; y += 0.91)
      for (double z = -9.9; z < 10; z += 0.87) {
        double r = std::sqrt(x * x + y * y + z * z);
        if (std::abs(r - 5) < 0.05) continue;
        EXPECT_NEAR(tree.Winding({x, y, z}), r < 5 ? 1 : 0, 0.05) << x << " " << y << " " << z;
      }
}

TEST(TriangleTreeTest, ProbeAgreesWithItselfWhateverTheOrder) {
  mesh::TriangleTree tree(Joined(SphereMesh(2, 12), SphereMesh(1, 8, {4, 0, 0})));
  mesh::SignedProbe walked(tree, tree);
  for (int k = 0; k < 3000; ++k) {
    // A walk with small and large steps.
    dvec3 p(5 * std::sin(0.013 * k), 2.2 * std::sin(0.17 * k), k % 7 == 0 ? 1.5 : 0.3);
    mesh::SignedProbe fresh(tree, tree);
    double limit = k % 2 ? 0.3 : 10.0;
    EXPECT_NEAR(walked.Distance(p, limit), fresh.Distance(p, limit), 1e-9) << k;
  }
}

TEST(TrianglesTest, VolumeAndAreaOfABox) {
  mesh::Triangles box = BoxMesh({100, 100, 100}, {101, 102, 103});
  EXPECT_NEAR(mesh::SignedVolume(box), 6, 1e-9);
  EXPECT_NEAR(mesh::SurfaceArea(box), 22, 1e-9);
}

TEST(TrianglesTest, EncodedMeshReadsBackWithItsPartsAndDamageIsRefused) {
  mesh::NamedMesh sphere{SphereMesh(5, 6), {{"enamel", "white", 0, 10}, {"", "", 10, 20}}};
  Bytes bytes = mesh::EncodeMesh(sphere);
  auto back = mesh::DecodeMesh(bytes);
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_EQ(back->mesh.indices, sphere.mesh.indices);
  ASSERT_EQ(back->parts.size(), 2u);
  EXPECT_EQ(back->parts[0].name, "enamel");
  EXPECT_EQ(back->parts[0].material, "white");
  EXPECT_EQ(back->parts[1].count, 20u);
  for (size_t n = 0; n < bytes.size(); ++n) EXPECT_FALSE(mesh::DecodeMesh({bytes.data(), n}).ok());
  Bytes longer = bytes;
  longer.push_back(0);
  EXPECT_FALSE(mesh::DecodeMesh(longer).ok());
  sphere.parts.clear();
  bytes = mesh::EncodeMesh(sphere);
  bytes[bytes.size() - 1] = 0x7f;  // an index out of range
  EXPECT_FALSE(mesh::DecodeMesh(bytes).ok());
}

}  // namespace
}  // namespace enamel::import
