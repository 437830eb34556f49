#include "common/import/band_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "shapes.h"

namespace enamel::import {
namespace {

using cutting::kBrickVoxels;

// The nearest of many points on a triangle: no formula in common with what is tested. Good to
// `h * h / 2d` where d is the distance.
double SampledDistance(const mesh::Triangles& mesh, const dvec3& p, int n) {
  double best = 1e300;
  for (const auto& t : mesh.indices) {
    const dvec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    for (int i = 0; i <= n; ++i)
      for (int k = 0; i + k <= n; ++k) {
        const dvec3 q = p - (a + (b - a) * (double(i) / n) + (c - a) * (double(k) / n));
        best = std::min(best, Dot(q, q));
      }
  }
  return std::sqrt(best);
}

mesh::Triangles RandomTriangles(int count, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  auto point = [&](double s) {
    return s * dvec3(uniform(random), uniform(random), uniform(random));
  };
  mesh::Triangles m;
  for (uint32_t i = 0; i < static_cast<uint32_t>(count); ++i) {
    const dvec3 at = point(0.8);
    for (int k = 0; k < 3; ++k) m.vertices.push_back(at + point(size));
    m.indices.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return m;
}

dvec3 SampleAt(const dvec3& corner, double h, int i) {
  return corner + h * dvec3(i % 8, i / 8 % 8, i / 64);
}

TEST(BandSamplerTest, DistancesAgreeWithPointsSpreadOverEveryTriangle) {
  const mesh::Triangles mesh = RandomTriangles(30, 0.3, 1);
  const mesh::TriangleTree tree(mesh);
  BandSampler band(tree);
  BandSampler::Samples d;
  const dvec3 corner(-0.2, -0.15, -0.1);
  band.Distances(corner, 0.05, 10, d);
  for (int i = 0; i < kBrickVoxels; i += 37) {
    const double expected = SampledDistance(mesh, SampleAt(corner, 0.05, i), 300);
    EXPECT_LE(d[static_cast<size_t>(i)], expected + 1e-5) << i;
    EXPECT_NEAR(d[static_cast<size_t>(i)], expected, 2e-3) << i;
  }
}

TEST(BandSamplerTest, DistancesAgreeWithTheTreesToAMillionthOfTheExtent) {
  for (double size : {0.02, 0.2, 2.0, 20.0}) {
    const mesh::Triangles mesh = RandomTriangles(400, size, 2);
    const mesh::TriangleTree tree(mesh);
    BandSampler band(tree);
    BandSampler::Samples d;
    for (const dvec3& corner : {dvec3(-0.9), dvec3(-0.2, 0.1, 0.3), dvec3(0.4)}) {
      for (double limit : {0.05, 0.2, 5.0}) {
        band.Distances(corner, 0.05, limit, d);
        for (int i = 0; i < kBrickVoxels; ++i) {
          EXPECT_NEAR(d[static_cast<size_t>(i)], tree.Distance(SampleAt(corner, 0.05, i), limit),
                      1e-6 * (1 + size) + 1e-6)
              << size << " " << i;
        }
      }
    }
  }
}

TEST(BandSamplerTest, TrianglesWithoutAnAreaAreMeasuredAsSegments) {
  mesh::Triangles mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}};
  mesh.indices = {{0, 1, 2}, {0, 0, 0}};
  const mesh::TriangleTree tree(mesh);
  BandSampler band(tree);
  BandSampler::Samples d;
  band.Distances({0, 0.3, 0.4}, 0.0, 5, d);
  EXPECT_NEAR(d[0], 0.5, 1e-6);
}

TEST(BandSamplerTest, SidesAreThoseOfTheWindingNumberAtEverySample) {
  const mesh::Triangles mesh = Joined(SphereMesh(0.31, 14), SphereMesh(0.2, 9, {0.2, 0.1, 0}));
  const mesh::TriangleTree tree(mesh);
  BandSampler band(tree);
  BandSampler::Samples d;
  std::array<bool, kBrickVoxels> inside;
  int asked = 0;
  const dvec3 corner(-0.02, -0.03, -0.04);
  band.Distances(corner, 0.05, 0.2, d);
  SidesOf(
      corner, 0.05, d,
      [&](const dvec3& p) {
        ++asked;
        return tree.Inside(p);
      },
      inside);
  for (int i = 0; i < kBrickVoxels; ++i)
    EXPECT_EQ(inside[static_cast<size_t>(i)], tree.Inside(SampleAt(corner, 0.05, i))) << i;
  EXPECT_LT(asked, 100);  // not once per sample
}

}  // namespace
}  // namespace enamel::import
