#include "station/lab/pictures/picture_change.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/math/vec.h"
#include "station/lab/pictures/flip.h"

namespace enamel::station::lab {
namespace {

using render::Image;

Image Painted(int width, int height, const std::function<dvec3(int x, int y)>& srgb) {
  Image out(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const dvec3 c = glm::clamp(srgb(x, y), 0.0, 255.0);
      for (int i = 0; i < 3; ++i) {
        out.rgb[static_cast<size_t>((y * width + x) * 3 + i)] =
            static_cast<uint8_t>(std::lround(c[i]));
      }
    }
  }
  return out;
}

// The mean of the authors' own program (NVlabs/flip, src/cpp/FLIP.h) for these two pictures at 15 and
// 67 pixels a degree.
TEST(FlipTest, AgreesWithTheAuthorsProgram) {
  const Image a = Painted(
      64, 48, [](int x, int y) { return dvec3(4 * x, 5 * y, x / 8 % 2 == y / 8 % 2 ? 200 : 40); });
  const Image b = Painted(64, 48, [](int x, int y) {
    return dvec3(4 * x, 5 * y + (x > 40 ? 12 : 0), x / 8 % 2 == (y + 1) / 8 % 2 ? 200 : 40);
  });
  const auto mean = [&](double pixels_per_degree) {
    double sum = 0;
    for (float each : Flip(a, b, pixels_per_degree)) sum += static_cast<double>(each);
    return sum / (64 * 48);
  };
  EXPECT_NEAR(mean(15), 0.212718, 1e-5);
  EXPECT_NEAR(mean(67), 0.176024, 1e-5);
}

TEST(FlipTest, FindsTheWorstPlace) {
  std::vector<float> map(40 * 30);
  for (int y = 20; y < 25; ++y) {
    for (int x = 8; x < 13; ++x) map[static_cast<size_t>(y * 40 + x)] = 1;
  }
  const WorstPlace worst = WorstOf(map, 40, 5);
  EXPECT_DOUBLE_EQ(worst.mean, 1);
  EXPECT_EQ(worst.x, 10);
  EXPECT_EQ(worst.y, 22);
  EXPECT_DOUBLE_EQ(WorstOf(map, 40, 10).mean, 0.25);
}

}  // namespace
}  // namespace enamel::station::lab
