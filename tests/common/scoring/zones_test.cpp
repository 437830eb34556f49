#include "common/scoring/zones.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

// Volume of a box cavity whose four upright edges have the bur's radius, mm^3.
double CavityVolume_mm3(const Cavity& c) {
  double corners = (4 - 3.14159265358979) * kBurRadius_mm * kBurRadius_mm;
  return ((c.mesial_mm + c.distal_mm) * (c.buccal_mm + c.lingual_mm) - corners) * c.depth_mm;
}

TEST(ZonesTest, BoxesGrowFromTheLandmark) {
  scene::Scene scene = BlockScene();
  scene.landmarks["occlusal_centre"] = {100, 200, 300};
  auto boxes = BoxesOf(scene, BlockExercise().target);
  ASSERT_TRUE(boxes.ok());
  EXPECT_NEAR(boxes->target.lo_m.x, -1.4e-3, 1e-12);
  EXPECT_NEAR(boxes->target.lo_m.z, -1.7e-3, 1e-12);
  EXPECT_NEAR(boxes->leeway.hi_m.y, 1.6e-3, 1e-12);
  EXPECT_NEAR(boxes->leeway.lo_m.z, -1.8e-3, 1e-12);
  EXPECT_NEAR(boxes->container.lo_m.x, -2.1e-3, 1e-12);
  EXPECT_NEAR(boxes->container.lo_m.z, -2.3e-3, 1e-12);
}

TEST(ZonesTest, AMissingLandmarkIsRefusedByName) {
  scene::CavityTarget target = BlockExercise().target;
  target.landmark = "fissure";
  auto boxes = BoxesOf(BlockScene(), target);
  ASSERT_FALSE(boxes.ok());
  EXPECT_EQ(boxes.status().code(), Code::kInvalidInput);
  EXPECT_NE(boxes.status().message().find("fissure"), std::string::npos);
}

// A disc of 1 mm, 1 mm deep, in the block: what a zone holds is its own volume, and a square cut
// about it takes all of the disc and what the square has more.
TEST(ZonesTest, ADiscsZonesAreDiscs) {
  const cutting::Volume block = MakeBlock(100'000);
  scene::CavityTarget target;
  target.half_size_um = {1'000, 1'000, 0};
  target.depth_um = 1'000;
  target.leeway_side_um = 250;
  target.leeway_bottom_um = 100;
  target.container_um = 100;
  scene::PreparationPart disc;
  disc.outline = scene::PreparationPart::Outline::kDisc;
  disc.half_size_um = {1'000, 1'000};
  disc.depth_um = 1'000;
  target.parts = {disc};
  auto zones = BoxesOf(BlockScene(), target);
  ASSERT_TRUE(zones.ok());
  scene::CavityTarget square = target;
  square.parts.clear();
  auto shape = scene::TargetShape(BlockScene(), square);
  ASSERT_TRUE(shape.ok());
  const cutting::Volume cut = scene::Prepared(block, *shape);
  auto measure = [&](Zone zone) { return MeasureZone(block, cut, *zones, zone); };
  const BoxVolume disc_zone = measure(Zone::kTarget), leeway = measure(Zone::kLeeway);
  EXPECT_NEAR(disc_zone.solid_m3 * 1e9, std::numbers::pi, 0.02);
  EXPECT_NEAR(disc_zone.removed_m3, disc_zone.solid_m3, 0.01e-9);
  EXPECT_NEAR(leeway.solid_m3 * 1e9, std::numbers::pi * 1.25 * 1.25 * 1.1, 0.04);
  // A square of 2 mm is within a disc of 1.25 mm but for its corners.
  EXPECT_GT((leeway.removed_m3 - disc_zone.removed_m3) * 1e9, 0.6);
  EXPECT_LT(leeway.removed_m3 * 1e9, 4);
  EXPECT_NEAR(measure(Zone::kContainer).solid_m3 * 1e9, std::numbers::pi * 1.35 * 1.35 * 1.2, 0.05);
}

TEST(ZonesTest, SolidInABoxThatLiesOffTheGridIsItsVolume) {
  cutting::Volume block = MakeBlock(100'000);
  OpenBox box{dvec3(-1.237e-3, -0.871e-3, -1.613e-3), dvec3(0.911e-3, 1.043e-3, 0)};
  BoxVolume v = MeasureBox(block, block, box);
  // The top is known to the fixed point: 6 nm of 4.1 mm^2.
  EXPECT_NEAR(v.solid_m3 * 1e9, 2.148 * 1.914 * 1.613, 5e-5);
  EXPECT_EQ(v.removed_m3, 0);
}

TEST(ZonesTest, ACutAlongTheTargetsFacesLeavesTheLeewayWhole) {
  for (int32_t voxel_nm : {100'000, 50'000}) {
    cutting::Volume block = MakeBlock(voxel_nm);
    Cavity cavity;
    cutting::Volume after = CutCavity(block, cavity);
    auto boxes = BoxesOf(BlockScene(), BlockExercise().target);
    BoxVolume target = MeasureBox(block, after, boxes->target);
    BoxVolume leeway = MeasureBox(block, after, boxes->leeway);
    EXPECT_NEAR(target.solid_m3 * 1e9, 3 * 2.4 * 2, 1e-3);
    // A voxel's fraction is taken as a plane's: off by a part of a voxel along 18 mm of inner
    // edges.
    double h_mm = voxel_nm * 1e-6, tolerance = 18 * 0.25 * h_mm * h_mm;
    EXPECT_NEAR(target.removed_m3 * 1e9, CavityVolume_mm3(cavity), tolerance) << voxel_nm;
    EXPECT_NEAR((leeway.removed_m3 - target.removed_m3) * 1e9, 0, tolerance) << voxel_nm;
  }
}

TEST(ZonesTest, AWallTooFarOutTakesTheLeewayAndThenTheContainer) {
  cutting::Volume block = MakeBlock(50'000);
  Cavity cavity;
  cavity.mesial_mm += 0.3;  // 0.2 leeway, 0.1 container
  cutting::Volume after = CutCavity(block, cavity);
  auto boxes = BoxesOf(BlockScene(), BlockExercise().target);
  double target = MeasureBox(block, after, boxes->target).removed_m3 * 1e9;
  double leeway = MeasureBox(block, after, boxes->leeway).removed_m3 * 1e9;
  double container = MeasureBox(block, after, boxes->container).removed_m3 * 1e9;
  EXPECT_NEAR(container, CavityVolume_mm3(cavity), 0.02);
  // The last 0.1 mm of the cavity, whose two edges are the ends of quarter circles.
  double r = kBurRadius_mm, chord = std::sqrt(r * r - 0.16);  // 0.1 mm short of the radius
  double segment = r * r * std::acos(0.8) - 0.4 * chord;      // of a circle cut 0.4 from its middle
  EXPECT_NEAR(container - leeway, ((2.4 - 2 * r) * 0.1 + segment) * 2, 0.02);
  EXPECT_GT(leeway - target, 0.8);
}

TEST(ZonesTest, RemovedPerTissueIsWhatTheCutterBooked) {
  cutting::Volume block = MakeBlock(100'000);
  Cavity cavity;
  cavity.depth_mm = 3.1;
  cutting::Volume after = CutCavity(block, cavity);
  auto removed = RemovedPerTissue_m3(block, after);
  auto before = cutting::SolidVolume_m3(block), left = cutting::SolidVolume_m3(after);
  for (size_t t = 0; t < removed.size(); ++t) EXPECT_NEAR(removed[t], before[t] - left[t], 1e-18);
  double area = CavityVolume_mm3(cavity) / cavity.depth_mm;
  // Labels change between samples, so a boundary may be half a voxel off.
  EXPECT_NEAR(removed[1] * 1e9, area * 1.2, area * 0.051);
  EXPECT_NEAR(removed[2] * 1e9, area * 1.6, area * 0.1);
  EXPECT_NEAR(removed[3] * 1e9, area * 0.3, area * 0.051);
}

}  // namespace
}  // namespace enamel::scoring
