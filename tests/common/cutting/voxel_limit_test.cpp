#include "common/cutting/voxel_limit.h"

#include <gtest/gtest.h>

#include <numbers>

namespace enamel::cutting {
namespace {

const Bur kSphere{BurShape::kSphere, 0.5e-3}, kCylinder{BurShape::kCylinder, 0.5e-3, 4e-3};

// A of a sphere's lower half: the integral of 1 - cos^2 is 4/3 pi r^2. Of a cylinder's side: pi r l.
TEST(VoxelLimitTest, PointsOfTheFrontDecide) {
  const double a_sphere = 4.0 / 3 * std::numbers::pi * 0.25, a_cylinder = std::numbers::pi * 2;
  EXPECT_NEAR(VoxelForceError(kSphere, 100'000), 1.1 * 0.09 / a_sphere, 1e-3);
  EXPECT_NEAR(VoxelForceError(kCylinder, 100'000), 2.0 * 0.09 / a_cylinder, 1e-3);
}

TEST(VoxelLimitTest, TheLargestVoxelIsTheLastWithinTenPercent) {
  for (const Bur& bur : {kSphere, kCylinder, Bur{BurShape::kWheel, 1.5e-3, 1e-3}}) {
    const int32_t largest_nm = LargestVoxel_nm(bur);
    EXPECT_LE(VoxelForceError(bur, largest_nm), kMaxVoxelForceError) << BurText(bur);
    EXPECT_GT(VoxelForceError(bur, largest_nm + 1000), kMaxVoxelForceError) << BurText(bur);
    EXPECT_FALSE(WhyTooCoarse(bur, largest_nm, true)) << BurText(bur);
  }
  EXPECT_EQ(LargestVoxel_nm(kCylinder), 186'000);
}

TEST(VoxelLimitTest, BurTwiceAsLargeMayHaveVoxelsTwiceAsLarge) {
  EXPECT_NEAR(LargestVoxel_nm({BurShape::kFlame, 0.6e-3, 4e-3, 0.3e-3}) * 2,
              LargestVoxel_nm({BurShape::kFlame, 1.2e-3, 8e-3, 0.6e-3}), 2000);
}

TEST(VoxelLimitTest, TheMessageNamesBurVoxelErrorAndTheVoxelThatDoes) {
  EXPECT_EQ(WhyTooCoarse(kSphere, 200'000, true),
            "voxels of 200 um are too coarse for the bur (sphere r 0.5 mm): its force is off by up "
            "to 38 %, "
            "and graded work may be off by 10 % at most. Use voxels of 102 um or less");
  EXPECT_NE(WhyTooCoarse(kSphere, 200'000, false)->find("practice teaches a wrong hand"),
            std::string::npos);
  // A disc whose rim is a hundredth of its surface: all points a bur has are too few.
  const Bur disc{BurShape::kWheel, 2e-3, 0.04e-3};
  EXPECT_EQ(LargestVoxel_nm(disc), 0);
  EXPECT_NE(WhyTooCoarse(disc, 10'000, true)->find("Use a larger bur"), std::string::npos);
}

}  // namespace
}  // namespace enamel::cutting
