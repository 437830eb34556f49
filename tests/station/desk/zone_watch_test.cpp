#include "station/desk/watch/zone_watch.h"

#include <gtest/gtest.h>

#include "common/cutting/cutter.h"
#include "common/scene/builtin/builtin.h"

namespace enamel::station::desk {
namespace {

class ZoneWatchTest : public testing::Test {
 protected:
  void SetUp() override {
    auto built = scene::BuildBuiltinScene("block", 100'000);
    ASSERT_TRUE(built.ok()) << built.status().message();
    scene_ = built->scene;
    volume_ = built->volume;
    target_.half_size_um = {1'500, 1'000, 0};
    target_.depth_um = 1'500;
    target_.leeway_side_um = target_.leeway_bottom_um = 250;
    target_.container_um = 500;
    auto at = scene_.landmarks.at(target_.landmark);
    top_ = dvec3(at[0], at[1], at[2]) * 1e-6;
  }
  // A bur of 1 mm pushed straight down `depth_m` beside the middle.
  cutting::Volume Drilled(double beside_m, double depth_m) const {
    cutting::Volume now = volume_;
    now.Reserve();
    cutting::Cutter cutter(now, {cutting::BurShape::kCylinder, 0.5e-3, 4e-3});
    cutting::RemovedUnits removed{};
    cutting::Pose pose;
    for (double z = 0.2e-3; z >= -depth_m; z -= 0.05e-3) {
      pose.tip_m = top_ + dvec3(beside_m, 0, z);
      cutter.Cut(pose, removed);
    }
    return now;
  }

  scene::Scene scene_;
  cutting::Volume volume_;
  scene::CavityTarget target_;
  dvec3 top_{0};
};

TEST_F(ZoneWatchTest, NothingIsGoneBeforeTheFirstCut) {
  ZoneWatch watch(scene_, target_, volume_);
  watch.Look(volume_);
  ASSERT_TRUE(watch.shares().has_value());
  EXPECT_EQ(watch.shares()->target_percent, 0);
  EXPECT_EQ(watch.shares()->leeway_percent, 0);
  EXPECT_EQ(watch.shares()->beyond_mm3, 0);
}

TEST_F(ZoneWatchTest, AHoleInsideTheTargetIsItsShareOfTheBox) {
  ZoneWatch watch(scene_, target_, volume_);
  watch.Look(Drilled(0, 1e-3));
  double hole = 3.14159265 * 0.5 * 0.5 * 1.0, box = 3.0 * 2.0 * 1.5;
  EXPECT_NEAR(watch.shares()->target_percent, 100 * hole / box, 0.6);
  EXPECT_NEAR(watch.shares()->leeway_percent, 0, 0.1);
  EXPECT_NEAR(watch.shares()->beyond_mm3, 0, 0.005);
}

TEST_F(ZoneWatchTest, AHoleTooDeepReachesTheLeewayAndThenWhatMustStay) {
  ZoneWatch watch(scene_, target_, volume_);
  watch.Look(Drilled(0, 2e-3));
  EXPECT_GT(watch.shares()->leeway_percent, 1);
  // 0.25 mm below the leeway.
  EXPECT_NEAR(watch.shares()->beyond_mm3, 3.14159265 * 0.25 * 0.25, 0.02);
}

TEST_F(ZoneWatchTest, AHoleFarFromTheTargetIsTooMuchAsAWhole) {
  ZoneWatch watch(scene_, target_, volume_);
  watch.Look(Drilled(5e-3, 1e-3));
  EXPECT_EQ(watch.shares()->target_percent, 0);
  EXPECT_NEAR(watch.shares()->beyond_mm3, 3.14159265 * 0.5 * 0.5, 0.05);
  EXPECT_EQ(watch.shares()->neighbour_mm3, 0);
}

TEST_F(ZoneWatchTest, WithoutATargetThereIsNothingToShow) {
  scene::CavityTarget none;
  EXPECT_FALSE(ZoneWatch(scene_, none, volume_).shares().has_value());
}

}  // namespace
}  // namespace enamel::station::desk
