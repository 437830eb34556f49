#include "station/render/mouth_mirror.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "station/render/gl_objects.h"
#include "station/render/picture.h"
#include "station/render/screen.h"
#include "tests/station/render/virtual_display.h"

namespace enamel::station::render {
namespace {

glm::vec3 At(const glm::mat4& m, const glm::vec3& p) { return glm::vec3(m * glm::vec4(p, 1)); }

TEST(MouthMirrorTest, IsOfSizeFour) { EXPECT_FLOAT_EQ(2 * kMirrorRadius_mm, 22); }

TEST(MouthMirrorTest, AnImageIsAsFarBehindTheGlassAsThePointIsBeforeIt) {
  const glm::mat4 at = glm::rotate(glm::translate(glm::mat4(1), {3, -2, 5}), 0.7f,
                                   glm::normalize(glm::vec3(1, 2, -0.5f)));
  const glm::mat4 reflection = Reflection(at);
  for (const glm::vec3& p : {glm::vec3(0), glm::vec3(4, 1, -3), glm::vec3(-20, 7, 9)}) {
    const glm::vec3 image = At(reflection, p);
    const glm::vec3 own = At(glm::inverse(at), p), mirrored = At(glm::inverse(at), image);
    EXPECT_NEAR(mirrored.x, own.x, 1e-4f);
    EXPECT_NEAR(mirrored.y, own.y, 1e-4f);
    EXPECT_NEAR(mirrored.z, -own.z, 1e-4f);
    EXPECT_LT(glm::distance(At(reflection, image), p), 1e-4f);
  }
}

// Wherever it is moved: the sight from the eye by the middle of the glass ends at the work.
TEST(MouthMirrorTest, ShowsThePlaceOfWorkInItsMiddle) {
  const glm::vec3 work(1, -2, 3);
  Camera camera(glm::vec3(0), 8, 0.16f);
  for (View view : {View::kOblique, View::kOcclusal, View::kBuccal, View::kMesial}) {
    camera.SetView(view);
    MouthMirror aside(work, true);
    aside.Show(true, camera);
    EXPECT_LT(aside.SceneFromMirror()[3].y, work.y - 6) << "beyond the crown";
    aside.Show(false, camera);
    MouthMirror mirror(work);
    mirror.Show(true, camera);
    for (int move = 0; move < 4; ++move) {
      const glm::mat4 at = mirror.SceneFromMirror();
      const glm::vec3 eye(glm::inverse(camera.ViewFromScene())[3]), middle(at[3]);
      const glm::vec3 image = At(Reflection(at), work);
      EXPECT_NEAR(
          glm::length(glm::cross(glm::normalize(image - eye), glm::normalize(middle - eye))), 0,
          1e-3f);
      EXPECT_GT(glm::dot(glm::vec3(at[2]), eye - middle), 0) << "the glass faces the viewer";
      mirror.Move(0.2f, move % 2 == 0 ? -0.15f : 0.1f, camera);
      mirror.Push(1.5f, camera);
    }
    EXPECT_NEAR(glm::determinant(glm::mat3(mirror.SceneFromMirror())), 1, 1e-4f);
  }
}

TEST(MouthMirrorTest, BeginsOnTheSideThatThePanelLeavesFree) {
  for (bool crown_aside : {false, true}) {
    glm::vec3 beside[2];
    for (bool left : {false, true}) {
      Camera camera(glm::vec3(0), 8, 0.16f);
      if (left) camera.MirrorAside();
      camera.SetView(View::kOcclusal);
      MouthMirror mirror(glm::vec3(0), crown_aside);
      mirror.Show(true, camera);
      const glm::vec3 middle(mirror.SceneFromMirror()[3]);
      beside[left ? 1 : 0] = {glm::dot(middle, camera.Right()), middle.y, middle.z};
      // The focus, and so the tooth, is on that side of the picture's middle as well.
      EXPECT_GT((left ? -1 : 1) * camera.ViewFromScene()[3].x, 0);
    }
    EXPECT_GT(beside[0].x, 4);
    EXPECT_NEAR(beside[1].x, -beside[0].x, 1e-3f);
    EXPECT_NEAR(beside[1].y, beside[0].y, 1e-3f);
    EXPECT_NEAR(beside[1].z, beside[0].z, 1e-3f);
  }
}

TEST(MouthMirrorTest, TiltedItTurnsAndStaysWhereItIs) {
  Camera camera(glm::vec3(0), 8);
  MouthMirror mirror(glm::vec3(0));
  mirror.Show(true, camera);
  const glm::mat4 before = mirror.SceneFromMirror();
  mirror.Tilt(0.1f, 0, camera);
  const glm::mat4 after = mirror.SceneFromMirror();
  EXPECT_LT(glm::distance(glm::vec3(before[3]), glm::vec3(after[3])), 1e-6f);
  EXPECT_GT(glm::dot(glm::vec3(after[2] - before[2]), camera.Right()), 0.05f);
}

// A plate that faces the viewer, ivory; its other side, red.
GroupMesh TwoSided() {
  GroupMesh mesh;
  auto side = [&](float y, int8_t normal, uint8_t tissue) {
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    for (float x : {-3.0f, 3.0f}) {
      for (float z : {-3.0f, 3.0f}) mesh.vertices.push_back({{x, y, z}, {0, normal, 0}, tissue});
    }
    std::array<uint32_t, 6> order{0, 1, 2, 2, 1, 3};
    if (normal < 0) order = {0, 2, 1, 2, 3, 1};
    for (uint32_t i : order) mesh.indices.push_back(first + i);
  };
  side(0.5f, 127, 1);
  side(-0.5f, -127, 3);
  mesh.bounds = BoundsOf(mesh.vertices, mesh.indices);
  return mesh;
}

TEST(MouthMirrorTest, ThePictureShowsInTheGlassAloneWhatIsHidden) {
  VirtualDisplay display;
  if (!display.ok()) GTEST_SKIP() << "skipped: Xvfb is not installed";
  ScreenOptions options;
  options.width_px = options.height_px = 400;
  options.paced = false;
  Screen screen(options);
  const cutting::Bur bur{cutting::BurShape::kCylinder, 0.6e-3, 4e-3};
  Picture picture(std::span(&bur, 1), 1);
  picture.Replace(TwoSided());
  Camera camera(glm::vec3(0), 16);
  camera.SetView(View::kBuccal);
  PictureState state;
  auto draw = [&] {
    screen.Begin();
    state.view_from_scene = camera.ViewFromScene();
    state.clip_from_view = camera.ClipFromView(1);
    picture.Draw(state, 400, 400, *FindQuality("good"));
    screen.Show(picture.result());
    screen.End();
    std::vector<uint8_t> rgba(size_t{400} * 400 * 4);
    picture.result().Bind();
    glReadPixels(0, 0, 400, 400, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
    return rgba;
  };
  auto red = [](const std::vector<uint8_t>& rgba) {
    int count = 0;
    for (size_t i = 0; i < rgba.size(); i += 4) count += rgba[i] > 80 && rgba[i] > 2 * rgba[i + 1];
    return count;
  };
  const std::vector<uint8_t> without = draw();
  EXPECT_EQ(red(without), 0);
  MouthMirror mirror(glm::vec3(0));
  mirror.Show(true, camera);
  camera.Zoom(3);  // as before
  state.scene_from_mirror = mirror.SceneFromMirror();
  EXPECT_GT(red(draw()), 400);
  // From behind the glass nothing is reflected.
  *state.scene_from_mirror = glm::rotate(*state.scene_from_mirror, 3.14159f, glm::vec3(0, 1, 0));
  EXPECT_EQ(red(draw()), 0);
  state.scene_from_mirror.reset();
  EXPECT_EQ(draw(), without) << "put away, it leaves no trace";
}

}  // namespace
}  // namespace enamel::station::render
