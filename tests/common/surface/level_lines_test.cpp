#include "common/surface/level_lines.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

namespace enamel::surface {
namespace {

using cutting::kBrickVoxels;

// A ball of 3 mm in a grid of 0.1 mm.
cutting::Volume Ball() {
  cutting::GridSpec spec{100'000, {9, 9, 9}, {-3'550'000, -3'550'000, -3'550'000}};
  cutting::Volume volume(spec);
  for (int b = 0; b < spec.brick_count(); ++b) {
    std::array<int16_t, kBrickVoxels> phi;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const ivec3 v = ivec3(b % 9, b / 9 % 9, b / 81) * 8 + ivec3(i & 7, i >> 3 & 7, i >> 6);
      const dvec3 p = spec.origin_m() * 1e3 + 0.1 * dvec3(v);
      phi[static_cast<size_t>(i)] = static_cast<int16_t>(
          std::clamp((glm::length(p) - 3) / 0.1 * cutting::kPhiPerVoxel, -32767.0, 32767.0));
    }
    volume.SetBrick(b, phi, {}, cutting::Tissue::kEnamel);
  }
  return volume;
}

TEST(LevelLinesTest, APlaneCutsABallInACircleThatIsClosed) {
  const Mesh mesh = ExtractSurface(Ball());
  std::vector<float> above;
  for (const glm::vec3& p : mesh.position_m) above.push_back(p.z - 1.8e-3f);
  const auto lines = ZeroLines(mesh, above);
  double length_mm = 0;
  std::map<std::tuple<float, float, float>, int> ends;
  for (const LineSegment& line : lines) {
    length_mm += 1e3 * glm::length(line.to_m - line.from_m);
    for (const glm::vec3& p : {line.from_m, line.to_m}) {
      ++ends[{p.x, p.y, p.z}];
      EXPECT_NEAR(p.z, 1.8e-3, 1e-8);
      EXPECT_NEAR(1e3 * std::hypot(p.x, p.y), 2.4, 0.01);
    }
  }
  EXPECT_NEAR(length_mm, 2 * std::numbers::pi * 2.4, 0.05);
  for (const auto& [end, count] : ends) EXPECT_EQ(count % 2, 0);
}

TEST(LevelLinesTest, NothingIsDrawnWhereTheFieldHasOneSign) {
  const Mesh mesh = ExtractSurface(Ball());
  EXPECT_TRUE(ZeroLines(mesh, std::vector<float>(mesh.position_m.size(), 1)).empty());
  EXPECT_TRUE(ZeroLines(mesh, std::vector<float>(mesh.position_m.size(), -1)).empty());
  EXPECT_TRUE(ZeroLines(Mesh{}, {}).empty());
}

}  // namespace
}  // namespace enamel::surface
