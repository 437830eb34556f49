#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/scene/builtin/builtin.h"
#include "station/mouth/mouth.h"
#include "station/render/gl_objects.h"
#include "station/render/screen.h"
#include "station/render/tooth_view.h"
#include "tests/station/render/virtual_display.h"

namespace enamel::station::mouth {
namespace {

using render::Quality;

constexpr int kWidth = 1280, kHeight = 720;

std::vector<double> Grey(const render::Target& picture) {
  std::vector<uint8_t> rgba(size_t{4} * kWidth * kHeight);
  picture.Bind();
  glReadPixels(0, 0, kWidth, kHeight, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  std::vector<double> out;
  for (size_t i = 0; i < rgba.size(); i += 4) {
    out.push_back(0.2126 * rgba[i] + 0.7152 * rgba[i + 1] + 0.0722 * rgba[i + 2]);
  }
  return out;
}

// Structural similarity (Wang et al., IEEE Trans. Image Process. 13, 2004), mean over windows of
// 8 x 8 pixels, half overlapping.
double Ssim(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr int kSide = 8, kStep = 4;
  constexpr double kC1 = 6.5025, kC2 = 58.5225;  // (0.01 and 0.03 of 255) squared
  double sum = 0, count = 0;
  for (int y = 0; y + kSide <= kHeight; y += kStep) {
    for (int x = 0; x + kSide <= kWidth; x += kStep) {
      double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
      for (int i = 0; i < kSide * kSide; ++i) {
        const auto at = static_cast<size_t>((y + i / kSide) * kWidth + x + i % kSide);
        sa += a[at], sb += b[at];
        saa += a[at] * a[at], sbb += b[at] * b[at], sab += a[at] * b[at];
      }
      constexpr double n = kSide * kSide;
      const double ma = sa / n, mb = sb / n, va = saa / n - ma * ma, vb = sbb / n - mb * mb,
                   v = sab / n - ma * mb;
      sum += (2 * ma * mb + kC1) * (2 * v + kC2) / ((ma * ma + mb * mb + kC1) * (va + vb + kC2));
      count += 1;
    }
  }
  return sum / count;
}

// A quarter of the pixels, fewer triangles and samples: nobody should see more than a little blur.
TEST(MouthTurningTest, WhileItTurnsThePictureIsAsLikeTheFullOneAsSsim95) {
  render::VirtualDisplay display;
  if (!display.ok()) GTEST_SKIP() << "skipped: Xvfb is not installed";
  auto built = scene::BuildBuiltinScene("molar", 100'000);
  ASSERT_TRUE(built.ok());
  render::ScreenOptions options;
  options.width_px = kWidth;
  options.height_px = kHeight;
  options.paced = false;
  render::Screen screen(options);
  render::ViewOptions view_options;
  view_options.burs = {{cutting::BurShape::kCylinder, 0.6e-3, 4e-3}};
  render::ToothView view(view_options, built->volume);
  ASSERT_TRUE(view.WaitIdle(std::chrono::seconds(60)));
  view.SetScenery(MakeMouth(built->scene, built->volume, {}));
  Quality good = *render::FindQuality("good");
  auto draw = [&](const Quality& quality) {
    screen.Begin();
    view.Draw(kWidth, kHeight, quality);
    screen.Show(view.result());
    screen.End();
    return Grey(view.result());
  };
  draw(good);
  for (float turn : {0.05f, 0.4f}) {
    view.camera().Orbit(turn, 0.01f);
    const std::vector<double> turning = draw(good);
    ASSERT_TRUE(view.work().coarse);
    good.lighter_turning = false;
    const std::vector<double> full = draw(good);
    good.lighter_turning = true;
    ASSERT_FALSE(view.work().coarse);
    const double ssim = Ssim(turning, full);
    RecordProperty("ssim", std::to_string(ssim));
    EXPECT_GE(ssim, 0.95);
  }
}

}  // namespace
}  // namespace enamel::station::mouth
