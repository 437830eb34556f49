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

}  // namespace
}  // namespace enamel::station::render
