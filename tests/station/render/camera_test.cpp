#include "station/render/camera.h"

#include <gtest/gtest.h>

#include "common/scene/tooth_number.h"

namespace enamel::station::render {
namespace {

// From mesial one sees a lower left molar from +x and a lower right one from -x.
TEST(CameraTest, TheMesialAndTheObliqueViewAreFromWhereTheToothsNumberHasIt) {
  for (int tooth : {36, 46, 0}) {
    Camera camera({0, 0, 0}, 8, 0, scene::MesialX(tooth));
    camera.SetView(View::kMesial);
    EXPECT_GT(scene::MesialX(tooth) * camera.TowardViewer().x, 0.9) << tooth;
    camera.SetView(View::kOblique);
    EXPECT_GT(scene::MesialX(tooth) * camera.TowardViewer().x, 0.2) << tooth;
    EXPECT_LT(camera.TowardViewer().y, -0.4) << tooth;
    camera.SetView(View::kBuccal);
    EXPECT_GT(camera.TowardViewer().y, 0.9) << tooth;
  }
}

TEST(CameraTest, WhereTheBurLeftThePicture) {
  Camera camera({0, 0, 0}, 8);
  camera.SetView(View::kOcclusal);  // x to the right, y up
  constexpr float kAspect = 1.5f;
  EXPECT_FALSE(camera.Away({0, 0, 0}, kAspect));
  EXPECT_FALSE(camera.Away({11, 0, 0}, kAspect)) << "wider than high";
  ASSERT_TRUE(camera.Away({0, 11, 0}, kAspect));
  EXPECT_LT(camera.Away({0, 11, 0}, kAspect)->y, -0.99f);
  EXPECT_GT(camera.Away({20, 0, 0}, kAspect)->x, 0.99f);
  const auto behind = camera.Away({-3, 0, 60}, kAspect);
  ASSERT_TRUE(behind);
  EXPECT_LT(behind->x, -0.99f);
}

TEST(CameraTest, AnUprightPictureIsAsWideAsAnotherIsHigh) {
  Camera camera({0, 0, 0}, 8);
  camera.SetView(View::kOcclusal);
  for (float aspect : {0.5f, 0.75f, 1.0f}) {
    EXPECT_FALSE(camera.Away({7.9f, 0, 0}, aspect)) << aspect;
    EXPECT_TRUE(camera.Away({8.1f, 0, 0}, aspect)) << aspect;
    EXPECT_FALSE(camera.Away({0, 7.9f / aspect, 0}, aspect)) << aspect;
    EXPECT_TRUE(camera.Away({0, 8.1f / aspect, 0}, aspect)) << aspect;
  }
}

}  // namespace
}  // namespace enamel::station::render
