#include "station/lab/cutting/force_error.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/cutting/voxel_limit.h"

namespace enamel::station::lab {
namespace {

using cutting::Bur;
using cutting::BurShape;
using cutting::LargestVoxel_nm;
using cutting::VoxelForceError;

// Of each shape long and short, slender and stout ones.
std::vector<std::vector<Bur>> BursByShape() {
  return {
      {{BurShape::kSphere, 0.5e-3}, {BurShape::kSphere, 0.9e-3}},
      {{BurShape::kCylinder, 0.5e-3, 1e-3}, {BurShape::kCylinder, 0.5e-3, 4e-3}},
      {{BurShape::kCone, 0.8e-3, 4e-3, 0}, {BurShape::kCone, 0.8e-3, 8e-3, 0.5e-3}},
      {{BurShape::kInvertedCone, 0.6e-3, 0.8e-3, 0.4e-3},
       {BurShape::kInvertedCone, 0.6e-3, 2.4e-3, 0.3e-3}},
      {{BurShape::kPear, 0.6e-3, 1.3e-3, 0.35e-3}, {BurShape::kPear, 0.6e-3, 4e-3, 0.2e-3}},
      {{BurShape::kFlame, 0.6e-3, 1.7e-3, 0.35e-3}, {BurShape::kFlame, 0.6e-3, 5.2e-3, 0.35e-3}},
      {{BurShape::kWheel, 1.2e-3, 0.4e-3}, {BurShape::kWheel, 1.5e-3, 1e-3}}};
}

// Were a bound no longer reached by any bur, it would refuse voxels for nothing.
TEST(ForceErrorTest, ForceOfACutIsWithinTheBoundOfItsVoxelAndReachesMostOfItForEachShape) {
  for (const std::vector<Bur>& burs : BursByShape()) {
    double closest = 0;
    for (const Bur& bur : burs) {
      const int32_t largest_nm = LargestVoxel_nm(bur);
      for (double share : {0.75, 0.85, 1.0, 1.15, 1.3, 1.5}) {
        const auto voxel_nm = static_cast<int32_t>(share * largest_nm);
        const double found = MeasureForceError(bur, voxel_nm),
                     bound = VoxelForceError(bur, voxel_nm);
        EXPECT_LE(found, bound) << BurText(bur) << " in " << voxel_nm << " nm";
        closest = std::max(closest, found / bound);
      }
    }
    EXPECT_GT(closest, 0.75) << BurShapeName(burs[0].shape);
  }
}

TEST(ForceErrorTest, ErrorFollowsTheVoxelAsAShareOfTheBur) {
  const Bur half{BurShape::kSphere, 0.25e-3}, whole{BurShape::kSphere, 0.5e-3};
  EXPECT_NEAR(MeasureForceError(half, 50'000), MeasureForceError(whole, 100'000), 0.005);
}

}  // namespace
}  // namespace enamel::station::lab
