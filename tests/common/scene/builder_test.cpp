#include "common/scene/builder.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numbers>

namespace enamel::scene {
namespace {

using cutting::Tissue;

constexpr double kRadius_m = 2e-3, kCore_m = 1e-3;

// Two concentric spheres; air says air, so that the builder has to fill labels in.
FieldSample Onion(const dvec3& p) {
  double r = std::sqrt(Dot(p, p));
  Tissue t = r > kRadius_m ? Tissue::kAir : r > kCore_m ? Tissue::kEnamel : Tissue::kDentin;
  return {r - kRadius_m, t, std::abs(r - kCore_m)};
}

cutting::GridSpec OnionGrid() { return GridAround(dvec3(-kRadius_m), dvec3(kRadius_m), 50'000); }

TEST(BuilderTest, SphereVolumesAgreeWithTheClosedForm) {
  auto volumes = cutting::SolidVolume_m3(BuildVolume(OnionGrid(), Field(Onion)));
  double whole = 4.0 / 3 * std::numbers::pi * kRadius_m * kRadius_m * kRadius_m;
  EXPECT_NEAR((volumes[1] + volumes[2]) / whole, 1, 0.002);
  EXPECT_NEAR(volumes[2] / (whole / 8), 1, 0.02);  // inner boundary is by voxel, not by distance
}

TEST(BuilderTest, NoVoxelOfAStoredBrickIsLabelledAir) {
  auto v = BuildVolume(OnionGrid(), Field(Onion));
  for (int b = 0; b < v.spec().brick_count(); ++b) {
    if (!v.IsStored(b)) continue;
    if (!v.HasLabels(b)) {
      EXPECT_NE(v.UniformTissue(b), Tissue::kAir);
      continue;
    }
    for (uint8_t t : v.Labels(b).tissue) ASSERT_NE(t, 0);
  }
}

TEST(BuilderTest, ResultDoesNotDependOnTheNumberOfThreads) {
  EXPECT_TRUE(BuildVolume(OnionGrid(), Field(Onion), 1) ==
              BuildVolume(OnionGrid(), Field(Onion), 3));
}

TEST(BuilderTest, SkippedBricksEqualSampledOnes) {
  auto sampled = [](const dvec3& p) {  // no margin: nothing inside may be skipped
    FieldSample f = Onion(p);
    f.tissue_margin_m = 0;
    return f;
  };
  EXPECT_TRUE(BuildVolume(OnionGrid(), Field(Onion)) == BuildVolume(OnionGrid(), Field(sampled)));
}

TEST(BuilderTest, DistanceIsThatOfTheFieldWithinTheBand) {
  auto v = BuildVolume(OnionGrid(), Field(Onion));
  for (double d = -0.19e-3; d < 0.2e-3; d += 0.01e-3) {
    EXPECT_NEAR(v.DistanceAt_m({0, 0, kRadius_m + d}), d, 1e-6);
  }
}

TEST(BuilderTest, ProgressRisesToOne) {
  double last = 0;
  BuildVolume(OnionGrid(), Field(Onion), 1, [&](double p) {
    EXPECT_GE(p, last);
    last = p;
  });
  EXPECT_EQ(last, 1);
}

}  // namespace
}  // namespace enamel::scene
