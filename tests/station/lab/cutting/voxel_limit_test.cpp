#include "station/lab/cutting/voxel_limit.h"

#include <gtest/gtest.h>

namespace enamel::station::lab {
namespace {

const cutting::Bur kSphere{cutting::BurShape::kSphere, 0.5e-3, 0};
const cutting::Bur kCylinder{cutting::BurShape::kCylinder, 0.6e-3, 4e-3};

TEST(VoxelLimitTest, ASmallBurInCoarseVoxelsIsRefusedForAGradeAndWarnedForPractice) {
  const double coarse = VoxelForceError(kSphere, 200'000), fine = VoxelForceError(kSphere, 50'000);
  EXPECT_GT(coarse, kMostVoxelForceError);
  EXPECT_LT(fine, kMostVoxelForceError);
  EXPECT_EQ(JudgeVoxel(coarse, true), VoxelVerdict::kRefused);
  EXPECT_EQ(JudgeVoxel(coarse, false), VoxelVerdict::kWarned);
  EXPECT_EQ(JudgeVoxel(fine, true), VoxelVerdict::kFine);
}

TEST(VoxelLimitTest, TheErrorFallsWithTheVoxel) {
  EXPECT_LT(VoxelForceError(kCylinder, 50'000), VoxelForceError(kCylinder, 200'000));
}

TEST(VoxelLimitTest, TheMessageNamesBurVoxelErrorAndTheVoxelThatDoes) {
  const int32_t finer = FinerVoxel_nm(kSphere, 200'000);
  ASSERT_GT(finer, 0);
  EXPECT_LE(VoxelForceError(kSphere, finer), kMostVoxelForceError);
  EXPECT_EQ(VoxelText(kSphere, 200'000, 0.51, true, 100'000),
            "voxels of 200 um are too coarse for a sphere r 0.5 mm: its force is off by 51 %, and "
            "graded work may be off by 10 % at most. Use voxels of 100 um or less");
  EXPECT_NE(VoxelText(kSphere, 200'000, 0.51, false, 0).find("Use a larger bur"),
            std::string::npos);
}

}  // namespace
}  // namespace enamel::station::lab
