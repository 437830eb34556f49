#include "station/desk/depth_gauge.h"

#include <gtest/gtest.h>

#include "tests/station/desk/english.h"

namespace enamel::station::desk {
namespace {

using cutting::GridSpec;
using cutting::kBrickVoxels;
using cutting::Volume;

constexpr int32_t kVoxel_nm = 50'000;

// A ball of 1.2 mm around 0, or all that is below z = 0 and beyond neither x nor -x by 1 mm.
template <typename Distance>
Volume Solid(Distance&& distance_m) {
  const GridSpec spec{kVoxel_nm, {8, 8, 8}, {-1'575'000, -1'575'000, -1'575'000}};
  Volume volume(spec);
  for (int b = 0; b < spec.brick_count(); ++b) {
    const ivec3 first = ivec3(b % 8, b / 8 % 8, b / 64) * 8;
    std::array<int16_t, kBrickVoxels> phi;
    for (size_t i = 0; i < kBrickVoxels; ++i) {
      const auto n = static_cast<int>(i);
      const dvec3 p =
          spec.origin_m() + spec.voxel_m() * dvec3(first + ivec3(n & 7, n >> 3 & 7, n >> 6));
      const double d = distance_m(p) / spec.voxel_m() * cutting::kPhiPerVoxel;
      phi[i] = static_cast<int16_t>(std::clamp(d, -32767.0, 32767.0));
    }
    volume.SetBrick(b, phi, {}, cutting::Tissue::kEnamel);
  }
  return volume;
}
Volume Ridge() {
  return Solid([](const dvec3& p) { return std::max(p.z, std::abs(p.x) - 1e-3); });
}

scene::CavityTarget TargetAt(const char* landmark) {
  scene::CavityTarget target;
  target.landmark = landmark;
  return target;
}

TEST(DepthGaugeTest, MeasuresACavityDownFromTheUncutSurface) {
  const Volume ridge = Ridge();
  const DepthGauge gauge(TargetAt("occlusal_centre"), ridge);
  for (double depth_m : {0.02e-3, 0.4e-3, 0.77e-3, 1.3e-3}) {
    // Nearer to the side than to the top, which must not matter.
    EXPECT_NEAR(*gauge.Depth_m({0.9e-3, 0, -depth_m}), depth_m, 1e-8) << depth_m;
  }
  EXPECT_FALSE(gauge.Depth_m({0, 0, 0.1e-3})) << "above it";
  EXPECT_FALSE(gauge.Depth_m({1.2e-3, 0, -1e-3})) << "beside it";
}

TEST(DepthGaugeTest, MeasuresACrownFromItsSidesToo) {
  const Volume ridge = Ridge();
  const DepthGauge gauge(TargetAt("crown_top"), ridge);
  EXPECT_NEAR(*gauge.Depth_m({0.8e-3, 0, -1.2e-3}), 0.2e-3, 1e-8);
  EXPECT_NEAR(*gauge.Depth_m({0, 0, -0.3e-3}), 0.3e-3, 1e-8);
  // At most 8 % too much, whatever the surface faces.
  constexpr double kBall_m = 1.2e-3, kDeep_m = 0.6e-3;
  const Volume ball = Solid([](const dvec3& p) { return glm::length(p) - kBall_m; });
  const DepthGauge on_ball(TargetAt("crown_top"), ball);
  for (int i = 0; i < 24; ++i) {
    const double a = i * 0.1309;  // 7.5 degrees, over half a turn
    const dvec3 p = (kBall_m - kDeep_m) * dvec3(std::cos(a), 0, std::sin(a));
    const double depth_m = *on_ball.Depth_m(p);
    EXPECT_GE(depth_m, kDeep_m - 1e-6) << i;
    EXPECT_LE(depth_m, 1.08 * kDeep_m) << i;
  }
}

TEST(DepthGaugeTest, WritesNoMoreThanTheVoxelsGive) {
  const Volume ridge = Ridge();
  const DepthGauge gauge(TargetAt("occlusal_centre"), ridge);
  EXPECT_EQ(gauge.Text(kEnglish, 1.3626e-3), "1.35 mm");
  EXPECT_EQ(gauge.Text(kEnglish, 0.01e-3), "0.00 mm");
  const Volume coarse(GridSpec{150'000, {1, 1, 1}, {0, 0, 0}});
  EXPECT_EQ(DepthGauge(TargetAt(""), coarse).Text(kEnglish, 1.3626e-3), "1.4 mm");
}

}  // namespace
}  // namespace enamel::station::desk
