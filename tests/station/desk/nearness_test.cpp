#include "station/desk/watch/nearness.h"

#include <gtest/gtest.h>

#include "common/scene/builtin/builtin.h"
#include "tests/station/desk/english.h"

namespace enamel::station::desk {
namespace {

using cutting::GridSpec;
using cutting::kBrickVoxels;
using cutting::Tissue;
using cutting::Volume;
using sound::Hazard;

constexpr double kVoxel_m = 0.1e-3;
constexpr cutting::Bur kRound{cutting::BurShape::kSphere, 0.5e-3};

// Solid everywhere, of 6.4 mm: pulp below z = -1 mm, an adjacent tooth beyond x = 1 mm, its surface
// there, and dentin elsewhere.
Volume Corner() {
  const GridSpec spec{100'000, {8, 8, 8}, {-3'150'000, -3'150'000, -3'150'000}};
  Volume volume(spec);
  for (int b = 0; b < spec.brick_count(); ++b) {
    const ivec3 first = ivec3(b % 8, b / 8 % 8, b / 64) * 8;
    std::array<int16_t, kBrickVoxels> phi;
    std::vector<uint8_t> labels(kBrickVoxels);
    for (size_t i = 0; i < kBrickVoxels; ++i) {
      const auto n = static_cast<int>(i);
      const dvec3 p = spec.origin_m() + kVoxel_m * dvec3(first + ivec3(n & 7, n >> 3 & 7, n >> 6));
      // A gap of 0.4 mm in front of the adjacent tooth.
      const double gap = std::abs(p.x - 0.8e-3) - 0.2e-3;
      phi[i] = static_cast<int16_t>(
          std::clamp(-gap / kVoxel_m * cutting::kPhiPerVoxel, -32767.0, 32767.0));
      labels[i] = static_cast<uint8_t>(p.x > 0.8e-3    ? Tissue::kNeighbour
                                       : p.z < -1.0e-3 ? Tissue::kPulp
                                                       : Tissue::kDentin);
    }
    volume.SetBrick(b, phi, labels, Tissue::kDentin);
  }
  return volume;
}

// The lowest point of a round bur is its tip; its side is a radius from the axis.
cutting::Pose TipAt(double x_mm, double z_mm) { return {{x_mm * 1e-3, 0, z_mm * 1e-3}, {}}; }

class NearnessTest : public testing::Test {
 protected:
  NearnessTest() { watch_.Look(); }
  const Volume corner_ = Corner();
  NearnessWatch watch_{{kRound}, corner_};
};

TEST_F(NearnessTest, WarnsOfPulpFromHalfAMillimetreOn) {
  EXPECT_EQ(watch_.Near(TipAt(-1, -0.44)).nearness, 0);
  const Warned at = watch_.Near(TipAt(-1, -0.8));
  EXPECT_EQ(at.about, Hazard::kPulp);
  // 0.2 mm of 0.5, known to half a voxel.
  EXPECT_NEAR(at.nearness, 1 - 0.2 / 0.5, 0.5 * kVoxel_m / kWarnPulp_m + 1e-9);
  EXPECT_GT(watch_.Near(TipAt(-1, -0.9)).nearness, at.nearness);
  EXPECT_EQ(watch_.Near(TipAt(-1, -1.2)).nearness, 1) << "in it";
}

TEST_F(NearnessTest, WarnsOfAnAdjacentToothFromThreeTenthsOn) {
  EXPECT_EQ(watch_.Near(TipAt(0.15, 1)).nearness, 0);
  const Warned at = watch_.Near(TipAt(0.35, 1));
  EXPECT_EQ(at.about, Hazard::kNeighbour);
  EXPECT_NEAR(at.nearness, 1 - 0.15 / 0.3, 0.02) << "its surface is known between voxels";
  EXPECT_EQ(watch_.Near(TipAt(0.6, 1)).nearness, 1);
}

TEST_F(NearnessTest, TheNearerForItsOwnDistanceIsNamed) {
  EXPECT_EQ(watch_.Near(TipAt(0.25, -0.9)).about, Hazard::kPulp);
  EXPECT_EQ(watch_.Near(TipAt(0.48, -0.6)).about, Hazard::kNeighbour);
}

TEST_F(NearnessTest, MeasuresTheBurAsItIsTilted) {
  NearnessWatch watch({{cutting::BurShape::kCylinder, 0.5e-3, 3e-3}}, corner_);
  watch.Look();
  cutting::Pose pose = TipAt(-2.2, 1);
  EXPECT_EQ(watch.Near(pose).nearness, 0);
  // On its side, its shank end toward the adjacent tooth: 3 mm to the right, 0.2 mm from it.
  pose.orientation = Quat{0, std::sqrt(0.5), 0, std::sqrt(0.5)};
  EXPECT_NEAR(watch.Near(pose).nearness, 1 - 0.2 / 0.3, 0.03);
}

TEST(NearTextTest, IsForThoseWhoDoNotHearTheTone) {
  EXPECT_EQ(NearText(kEnglish, {Hazard::kPulp, 0}), "");
  EXPECT_EQ(NearText(kEnglish, {Hazard::kPulp, 0.4}), "Pulp: 0.3 mm away");
  EXPECT_EQ(NearText(kEnglish, {Hazard::kNeighbour, 1.0 / 3}), "Adjacent tooth: 0.2 mm away");
  EXPECT_EQ(NearText(kEnglish, {Hazard::kPulp, 1}), "Pulp: 0.0 mm away");
}

TEST_F(NearnessTest, MeasuresTheBurInTheHandpiece) {
  NearnessWatch watch({kRound, {cutting::BurShape::kSphere, 0.1e-3}}, corner_);
  watch.Look();
  EXPECT_EQ(watch.Near(TipAt(0.35, 1)).nearness, watch_.Near(TipAt(0.35, 1)).nearness);
  EXPECT_EQ(watch.Near(TipAt(0.35, 1), 1).nearness, 0) << "it is thinner";
}

TEST_F(NearnessTest, NothingIsNearBeforeTheSurfacesAreFound) {
  const NearnessWatch watch({kRound}, corner_);
  EXPECT_EQ(watch.Near(TipAt(-1, -1.2)).nearness, 0);
}

}  // namespace
}  // namespace enamel::station::desk
