#include "common/scene/preparation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "common/scene/builtin/builtin.h"

namespace enamel::scene {
namespace {

using Outline = PreparationPart::Outline;

Preparation One(PreparationPart part) { return {"one", "One", {std::move(part)}}; }

// Share of random points of a box that are inside, times the box's volume.
double VolumeInside_mm3(const Preparation& p, const dvec3& lo_mm, const dvec3& hi_mm) {
  std::mt19937 random(5);
  constexpr int kPoints = 200'000;
  int inside = 0;
  for (int i = 0; i < kPoints; ++i) {
    dvec3 q;
    for (int k = 0; k < 3; ++k)
      q[k] = std::uniform_real_distribution<double>(lo_mm[k], hi_mm[k])(random) * 1e-3;
    inside += PreparationDistance_m(p, q) < 0;
  }
  const dvec3 e = hi_mm - lo_mm;
  return e.x * e.y * e.z * inside / kPoints;
}

// A part without the members that only some outlines have.
PreparationPart Part(Outline outline, std::array<int32_t, 2> half_um, int32_t depth_um) {
  PreparationPart part;
  part.outline = outline;
  part.half_size_um = half_um;
  part.depth_um = depth_um;
  return part;
}

TEST(PreparationTest, AnLShapedPolygonTakesItsAreaTimesItsDepth) {
  PreparationPart part = Part(Outline::kPolygon, {}, 1'000);
  // 3 x 2 without a corner of 2 x 1.
  part.corners_um = {{0, 0},         {3'000, 0},     {3'000, 1'000},
                     {1'000, 1'000}, {1'000, 2'000}, {0, 2'000}};
  const Preparation shape = One(part);
  EXPECT_NEAR(VolumeInside_mm3(shape, {-1, -1, -2}, {4, 3, 0}), 4, 0.1);
  const dvec3 deep(0, 0, -0.5e-3);
  EXPECT_NEAR(PreparationDistance_m(shape, dvec3(0.4e-3, 1e-3, 0) + deep), -0.4e-3, 1e-12);
  // In the bay: from both sides.
  EXPECT_NEAR(PreparationDistance_m(shape, dvec3(1.3e-3, 1.2e-3, 0) + deep), 0.2e-3, 1e-12);
  EXPECT_NEAR(PreparationDistance_m(shape, dvec3(-3e-3, -4e-3, 0) + deep), 5e-3, 1e-12);
}

TEST(PreparationTest, AFinePolygonIsTheDisc) {
  PreparationPart polygon = Part(Outline::kPolygon, {}, 1'500);
  for (int i = 0; i < 64; ++i) {
    polygon.corners_um.push_back(
        {static_cast<int32_t>(std::lround(2'500 * std::cos(i * std::numbers::pi / 32))),
         static_cast<int32_t>(std::lround(2'500 * std::sin(i * std::numbers::pi / 32)))});
  }
  const Preparation a = One(polygon), b = One(Part(Outline::kDisc, {2'500, 2'500}, 1'500));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-4e-3, 4e-3);
  for (int i = 0; i < 500; ++i) {
    const dvec3 p(place(random), place(random), place(random));
    // 2.5 mm (1 - cos(pi / 64)) and half a micrometre of rounding.
    EXPECT_NEAR(PreparationDistance_m(a, p), PreparationDistance_m(b, p), 4e-6);
  }
}

TEST(PreparationTest, AStumpsHollowIsTheBoxWithoutAFrustum) {
  PreparationPart part = Part(Outline::kStump, {6'000, 5'000}, 5'000);
  part.stump.foot = {{200, -100}, {4'000, 3'000}};
  part.stump.table = {{0, 100}, {3'000, 2'400}};
  part.stump.table_below_um = 1'000;
  const Preparation shape = One(part);
  // Prismatoid: height (A0 + 4 Am + A1) / 6; above the table all of the box goes.
  const double frustum = 4.0 / 6 * (8 * 6 + 4 * 7 * 5.4 + 6 * 4.8);
  EXPECT_NEAR(VolumeInside_mm3(shape, {-6, -5, -6}, {6, 5, 0}), 12 * 10 * 5 - frustum, 4);
  // Over the table's middle, and beside the foot.
  EXPECT_NEAR(PreparationDistance_m(shape, {0, 0, -0.9e-3}), -0.1e-3, 1e-9);
  EXPECT_NEAR(PreparationDistance_m(shape, {0, 0, -1.2e-3}), 0.2e-3, 1e-9);
  EXPECT_GT(PreparationDistance_m(shape, {4.1e-3, 0, -4.99e-3}), 0);
  EXPECT_LT(PreparationDistance_m(shape, {4.4e-3, 0, -4.8e-3}), 0);
}

TEST(PreparationTest, GrowingMovesWallsAndFloorAsFarAsIsSaid) {
  const Growth grown{0.25e-3, 0.1e-3};
  PreparationPart polygon = Part(Outline::kPolygon, {}, 1'000);
  polygon.corners_um = {{-1'000, -1'000}, {1'000, -1'000}, {1'000, 1'000}, {-1'000, 1'000}};
  PreparationPart stump = Part(Outline::kStump, {4'000, 4'000}, 1'000);
  stump.stump.foot = stump.stump.table = {{0, 0}, {2'000, 2'000}};
  stump.stump.table_below_um = 200;
  for (const PreparationPart& part : {Part(Outline::kBox, {1'000, 1'000}, 1'000),
                                      Part(Outline::kDisc, {1'000, 1'000}, 1'000), polygon}) {
    EXPECT_NEAR(PreparationDistance_m(One(part), {1.25e-3, 0, -0.5e-3}, grown), 0, 1e-12);
    EXPECT_NEAR(PreparationDistance_m(One(part), {0, 0, -1.1e-3}, grown), 0, 1e-12);
  }
  // A stump gets thinner and its table lower.
  EXPECT_NEAR(PreparationDistance_m(One(stump), {1.75e-3, 0, -0.6e-3}, grown), 0, 1e-12);
  EXPECT_NEAR(PreparationDistance_m(One(stump), {0, 0, -0.3e-3}, grown), 0, 1e-12);
  EXPECT_NEAR(PreparationDistance_m(One(stump), {3e-3, 0, -1.1e-3}, grown), 0, 1e-12);
}

// A roof whose ridge runs along y: 1 mm below the opening in the middle, 2 mm at x = +-2 mm.
PreparationPart WithRoof(PreparationPart part) {
  part.relief = {2'000, {3, 1}, {2'000, 1'000, 2'000}};
  return part;
}

TEST(PreparationTest, AReliefIsTheFloorOfABoxAndTheTableOfAStump) {
  const Preparation box = One(WithRoof(Part(Outline::kBox, {3'000, 1'000}, 2'000)));
  // Over the slope by half a millimetre straight up; level beyond the outermost points.
  const double across = 1 / std::sqrt(1 + 0.25);
  EXPECT_NEAR(PreparationDistance_m(box, {1e-3, 0, -1e-3}), -0.5e-3 * across, 1e-12);
  EXPECT_NEAR(PreparationDistance_m(box, {1e-3, 0, -2e-3}), 0.5e-3 * across, 1e-12);
  EXPECT_NEAR(PreparationDistance_m(box, {2.8e-3, 0, -2.1e-3}), 0.1e-3, 1e-12);
  // 6 x 2 mm, on average 1.5 mm deep over 4 mm and 2 mm deep at both ends.
  EXPECT_NEAR(VolumeInside_mm3(box, {-3, -1, -2.5}, {3, 1, 0}), 2 * (4 * 1.5 + 2 * 2), 0.1);

  PreparationPart stump = WithRoof(Part(Outline::kStump, {4'000, 4'000}, 4'000));
  stump.stump.foot = stump.stump.table = {{0, 0}, {2'000, 2'000}};
  stump.stump.table_below_um = 1'000;
  EXPECT_NEAR(PreparationDistance_m(One(stump), {1e-3, 0, -2e-3}), 0.5e-3 * across, 1e-12);
  EXPECT_NEAR(PreparationDistance_m(One(stump), {1e-3, 0, -1e-3}), -0.5e-3 * across, 1e-12);
  // 8 x 8 x 4 mm without the house: 4 x 4 mm, 2 mm high at the eaves and 3 mm at the ridge.
  EXPECT_NEAR(VolumeInside_mm3(One(stump), {-4, -4, -4.5}, {4, 4, 0}), 8 * 8 * 4 - 4 * 4 * 2.5,
              0.5);
}

TEST(PreparationTest, AReliefGrowsStraightDown) {
  const Preparation box = One(WithRoof(Part(Outline::kBox, {3'000, 1'000}, 2'000)));
  const dvec3 on_slope(1e-3, 0, -1.5e-3);
  EXPECT_NEAR(PreparationDistance_m(box, on_slope), 0, 1e-12);
  EXPECT_NEAR(PreparationDistance_m(box, on_slope - dvec3(0, 0, 0.3e-3), {0, 0.3e-3}), 0, 1e-12);
}

TEST(PreparationTest, WhatIsPreparedHasTheReliefAsItsFloor) {
  auto block = BuildBuiltinScene("block", 100'000);
  ASSERT_TRUE(block.ok());
  PreparationPart part = WithRoof(Part(Outline::kBox, {3'000, 2'000}, 2'000));
  part.top_um = {0, 0, 5'000};
  const cutting::Volume after = Prepared(block->volume, One(part));
  for (double x : {-1.5e-3, -0.5e-3, 0.5e-3, 1.5e-3, 2.5e-3}) {
    const ReliefPoint at = ReliefAt(part, x, 0.4e-3);
    EXPECT_NEAR(after.DistanceAt_m({x, 0.4e-3, at.z_m}), 0, 10e-6) << x;
  }
}

TEST(PreparationTest, ATargetWithoutPartsIsItsBox) {
  Scene scene;
  scene.landmarks["occlusal_centre"] = {100, 200, 300};
  CavityTarget target;
  target.half_size_um = {2'000, 1'000, 0};
  target.depth_um = 1'500;
  auto shape = TargetShape(scene, target);
  ASSERT_TRUE(shape.ok());
  EXPECT_NEAR(PreparationDistance_m(*shape, {2.1e-3, 0.2e-3, 0}), 0, 1e-12);
  EXPECT_NEAR(PreparationDistance_m(*shape, {0.1e-3, 0.2e-3, -1.2e-3}), 0, 1e-12);
  target.landmark = "elsewhere";
  EXPECT_EQ(TargetShape(scene, target).status().field(), "target.landmark");
}

// The block's shapes, and whatever else has parts: the exercise asks for what the scene calls so.
TEST(PreparationTest, TheBlocksExercisesAskForItsShapes) {
  auto block = BuildBuiltinScene("block", 200'000);
  ASSERT_TRUE(block.ok());
  size_t round = 0;
  for (const Exercise& e : BuiltinExercises(block->scene, {})) {
    auto shape = TargetShape(block->scene, e.target);
    ASSERT_TRUE(shape.ok());
    EXPECT_TRUE(HoldsItsParts(e.target)) << e.name;
    for (const Preparation& p : block->scene.preparations) {
      if (p.name == e.target.landmark) {
        EXPECT_EQ(shape->parts, p.parts) << e.name;
      }
    }
    if (!e.name.starts_with("circle")) continue;
    ++round;
    // Not the square around it.
    const dvec3 corner(5e-3 + 2.4e-3, 5e-3 + 2.4e-3, 4e-3);
    EXPECT_GT(PreparationDistance_m(*shape, corner), 0.8e-3);
  }
  EXPECT_EQ(round, 1u);
}

}  // namespace
}  // namespace enamel::scene
