#include "common/cutting/volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/analytic_volume.h"

namespace enamel::cutting {
namespace {

TEST(VolumeTest, TrilinearDistanceIsExactOnAFlatFace) {
  Volume block = test::Block(50'000, 2e-3, 2e-3);
  for (double z : {-150e-6, -37e-6, 0.0, 12e-6, 99e-6}) {
    EXPECT_NEAR(block.DistanceAt_m(dvec3(0.3e-3, -0.21e-3, z)), z, 7e-9);
  }
}

TEST(VolumeTest, DistanceSaturatesNearFourVoxelsAndOutsideTheGridIsAir) {
  Volume block = test::Block(50'000, 2e-3, 2e-3);
  EXPECT_NEAR(block.DistanceAt_m(dvec3(0, 0, -1e-3)), -4 * 50e-6, 1e-8);
  EXPECT_NEAR(block.DistanceAt_m(dvec3(1, 1, 1)), 4 * 50e-6, 1e-8);
  EXPECT_NEAR(block.DistanceAt_m(dvec3(std::nan(""), 0, 0)), 4 * 50e-6, 1e-8);
}

// A voxel's solid fraction is exact on average for a plane; what is left is curvature, (h/r)^2.
TEST(VolumeTest, SolidVolumeOfASphereIsWithinTheSquareOfVoxelOverRadius) {
  double r = 1.3e-3, exact = 4.0 / 3 * M_PI * r * r * r;
  for (int32_t voxel_nm : {200'000, 100'000, 50'000, 25'000}) {
    GridSpec spec{
        voxel_nm, ivec3(3'200'000 / voxel_nm / 8 + 1), {-1'600'000, -1'600'000, -1'600'000}};
    Volume ball =
        test::VolumeOf(spec, Tissue::kDentin, [&](const dvec3& p) { return glm::length(p) - r; });
    double h = voxel_nm * 1e-9;
    EXPECT_NEAR(SolidVolume_m3(ball)[2] / exact, 1, 0.5 * h * h / (r * r)) << voxel_nm;
  }
}

TEST(VolumeTest, UniformBrickBecomesStoredOnDemandAndOnlyWithinTheReserve) {
  Volume block = test::Block(50'000, 2e-3, 2e-3);
  int deep = -1;
  for (int b = 0; b < block.spec().brick_count(); ++b) {
    if (!block.IsStored(b) && block.UniformTissue(b) == Tissue::kEnamel) deep = b;
  }
  ASSERT_GE(deep, 0);
  Volume copy = block;
  copy.Reserve();
  EXPECT_TRUE(copy.Materialise(deep));
  EXPECT_EQ(copy.Phi(deep).phi[0], -kPhiLimit);
  EXPECT_EQ(copy.UniformTissue(deep), Tissue::kEnamel);
  EXPECT_FALSE(copy == block);
}

// 2 MB of room are resident from the start and kept ahead of what is used; a copy shares nothing.
TEST(VolumeTest, RoomForEverySolidBrickIsThereAndCopiesAreIndependent) {
  Volume block = test::Block(50'000, 4e-3, 4e-3);
  block.Reserve();
  Volume copy = block;
  copy.Reserve();
  int materialised = 0;
  for (int b = 0; b < block.spec().brick_count(); ++b) {
    if (block.IsStored(b) || block.UniformTissue(b) == Tissue::kAir) continue;
    block.Warm();
    ASSERT_TRUE(block.Materialise(b));
    block.MutablePhi(b).phi.fill(1);
    ++materialised;
  }
  EXPECT_GT(materialised, 1000);
  for (int b = 0; b < copy.spec().brick_count(); ++b) {
    if (copy.IsStored(b)) continue;
    ASSERT_NE(copy.UniformTissue(b) == Tissue::kAir, block.IsStored(b));
  }
  copy = block;
  EXPECT_TRUE(copy == block);
}

TEST(GridSpecTest, SizesNoToothNeedsAreRefusedWithTheNumber) {
  EXPECT_FALSE(ValidateGrid({1'000, ivec3(8), {}}).ok());
  EXPECT_FALSE(ValidateGrid({50'000, ivec3(0, 8, 8), {}}).ok());
  EXPECT_FALSE(ValidateGrid({50'000, ivec3(8), {0, INT64_MIN, 0}}).ok());
  Status huge = ValidateGrid({5'000, ivec3(1000), {}});
  EXPECT_EQ(huge.code(), Code::kTooLarge);
  EXPECT_NE(huge.message().find("MiB"), std::string::npos);
}

// Against seven interpolations in double precision, across bricks and where a cut knows no distance.
TEST(VolumeTest, DistanceAndSlopeAreThoseOfTheInterpolation) {
  Volume v = test::Block(100'000, 2e-3, 6e-3);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(0, 1);
  const ivec3 n = v.spec().voxels();
  int near = 0;
  for (int i = 0; i < 200'000; ++i) {
    const dvec3 g(3 + any(random) * (n.x - 6), 3 + any(random) * (n.y - 6),
                  3 + any(random) * (n.z - 6));
    const double exact = v.DistanceAtSample(g);
    dvec3 slope;
    const double distance = v.DistanceAndSlope(g, 0.5, slope);
    if (std::fabs(exact) > 1) {
      ASSERT_GT(std::fabs(distance), 0.99);
      continue;
    }
    ASSERT_NEAR(distance, exact, 1e-5);
    if (distance >= 0.5) {
      ASSERT_EQ(slope, dvec3(0));
      continue;
    }
    ++near;
    for (int a = 0; a < 3; ++a) {
      dvec3 half(0);
      half[a] = 0.5;
      ASSERT_NEAR(slope[a], v.DistanceAtSample(g + half) - v.DistanceAtSample(g - half), 1e-5);
    }
  }
  EXPECT_GT(near, 1000);
}

}  // namespace
}  // namespace enamel::cutting
