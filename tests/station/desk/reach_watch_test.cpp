#include "station/desk/watch/reach_watch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/cutting/cutter.h"
#include "common/scene/builtin/builtin.h"

namespace enamel::station::desk {
namespace {

using cutting::GridSpec;
using cutting::kBrickVoxels;
using cutting::Tissue;
using cutting::Volume;

constexpr double kRadius_m = 0.5e-3;

// A block of 8 x 8 x 5.6 mm at 0.1 mm, its top at z = 0, of dentin; pulp where `is_pulp` (m) is
// true.
template <typename IsPulp>
Volume Block(IsPulp&& is_pulp) {
  GridSpec spec{100'000, {12, 12, 9}, {-4'750'000, -4'750'000, -6'350'000}};
  Volume volume(spec);
  for (int b = 0; b < spec.brick_count(); ++b) {
    ivec3 first = ivec3(b % 12, b / 12 % 12, b / 144) * 8;
    std::array<int16_t, kBrickVoxels> phi;
    std::vector<uint8_t> labels(kBrickVoxels);
    for (size_t i = 0; i < kBrickVoxels; ++i) {
      auto n = static_cast<int>(i);
      dvec3 p = spec.origin_m() + spec.voxel_m() * dvec3(first + ivec3(n & 7, n >> 3 & 7, n >> 6));
      dvec3 q = glm::abs(p - dvec3(0, 0, -2.8e-3)) - dvec3(4e-3, 4e-3, 2.8e-3);
      double d = std::max({q.x, q.y, q.z}) / spec.voxel_m() * cutting::kPhiPerVoxel;
      phi[i] = static_cast<int16_t>(std::clamp(d, -32767.0, 32767.0));
      labels[i] = static_cast<uint8_t>(is_pulp(p) ? Tissue::kPulp : Tissue::kDentin);
    }
    volume.SetBrick(b, phi, labels, Tissue::kDentin);
  }
  return volume;
}

scene::Scene SceneWithTop() {
  scene::Scene scene;
  scene.landmarks["occlusal_centre"] = {0, 0, 0};
  return scene;
}

// 3 x 2 mm and 1.5 mm deep; 0.25 mm of leeway beside it, 0.4 mm below.
scene::CavityTarget Target() {
  scene::CavityTarget target;
  target.half_size_um = {1'500, 1'000, 0};
  target.depth_um = 1'500;
  target.leeway_side_um = 250;
  target.leeway_bottom_um = 400;
  target.container_um = 500;
  return target;
}

// The box from -x to +x and -y to +y (m), cut down to `depth_m` by a cylinder of 1 mm.
Volume Cut(const Volume& block, dvec3 half_m, double depth_m, dvec3 off_m = dvec3(0)) {
  Volume now = block;
  now.Reserve();
  cutting::Cutter cutter(now, {cutting::BurShape::kCylinder, kRadius_m, 6e-3});
  cutting::RemovedUnits removed{};
  cutting::Pose pose;
  double x_end = half_m.x - kRadius_m, y_end = half_m.y - kRadius_m;
  for (double y = -y_end; y <= y_end + 1e-9; y += std::max(y_end, 0.1e-3) / 4) {
    for (double x = -x_end; x <= x_end + 1e-9; x += std::max(x_end, 0.1e-3) / 8) {
      for (double z : {0.2e-3, -depth_m, 0.2e-3}) {
        pose.tip_m = dvec3(x, y, z) + off_m;
        cutter.Cut(pose, removed);
      }
    }
  }
  return now;
}

render::Reach After(const Volume& block, const Volume& now, int tooth = 0) {
  scene::Scene scene = SceneWithTop();
  scene.tooth = tooth;
  ReachWatch watch(scene, Target(), block);
  watch.Look(now);
  return watch.reach();
}

bool Nowhere(const dvec3&) { return false; }
// Half-way between two layers of samples.
constexpr double kPulpTop_m = 3.0e-3;
bool BelowThreeMillimetres(const dvec3& p) { return p.z < -kPulpTop_m; }

TEST(ReachWatchTest, BeforeTheFirstCutAllOfTheLeewayIsLeftAndThePulpIsFar) {
  Volume block = Block(BelowThreeMillimetres);
  render::Reach reach = After(block, block);
  ASSERT_TRUE(reach.leeway && reach.pulp_mm);
  EXPECT_DOUBLE_EQ(reach.leeway->left_mm, reach.leeway->whole_mm);
  EXPECT_EQ(reach.leeway->where, "");
  EXPECT_DOUBLE_EQ(*reach.pulp_mm, render::kPulpFar_mm);
}

TEST(ReachWatchTest, ABoxCutToAKnownDepthLeavesWhatIsBelowIt) {
  Volume block = Block(BelowThreeMillimetres);
  for (double depth_mm : {1.2, 1.63, 1.87, 2.04}) {
    render::Reach reach = After(block, Cut(block, {1.4e-3, 0.9e-3, 0}, depth_mm * 1e-3));
    bool beyond = depth_mm > 1.5;
    EXPECT_NEAR(reach.leeway->left_mm, beyond ? 1.9 - depth_mm : 0.25, 0.003) << depth_mm;
    EXPECT_EQ(reach.leeway->where, beyond ? "reach.floor" : "");
    EXPECT_NEAR(*reach.pulp_mm, kPulpTop_m * 1e3 - depth_mm, 0.003) << depth_mm;
  }
}

TEST(ReachWatchTest, TheWallThatIsNearestToItsLimitIsNamed) {
  Volume block = Block(Nowhere);
  struct Case {
    dvec3 off_m;
    const char* where;
  };
  // The cut has the target's size less 0.1 mm all around, and is 0.28 mm off: 0.18 mm too far.
  for (const Case& c :
       {Case{{0.28e-3, 0, 0}, "mesial_wall"}, Case{{-0.28e-3, 0, 0}, "distal_wall"},
        Case{{0, 0.28e-3, 0}, "buccal_wall"}, Case{{0, -0.28e-3, 0}, "lingual_wall"}}) {
    render::Reach reach = After(block, Cut(block, {1.4e-3, 0.9e-3, 0}, 1e-3, c.off_m));
    EXPECT_EQ(reach.leeway->where, std::string("reach.") + c.where);
    EXPECT_NEAR(reach.leeway->left_mm, 0.25 - 0.18, 0.01);
  }
  const Volume to_right = Cut(block, {1.4e-3, 0.9e-3, 0}, 1e-3, {0.28e-3, 0, 0});
  EXPECT_EQ(After(block, to_right, 36).leeway->where, "reach.mesial_wall");
  EXPECT_EQ(After(block, to_right, 46).leeway->where, "reach.distal_wall");
}

TEST(ReachWatchTest, BeyondTheLeewayWhatIsLeftIsBelowZero) {
  Volume block = Block(Nowhere);
  render::Reach reach = After(block, Cut(block, {1.4e-3, 0.9e-3, 0}, 2.2e-3));
  EXPECT_NEAR(reach.leeway->left_mm, -0.3, 0.003);
  EXPECT_FALSE(reach.pulp_mm.has_value());
}

// A ball of pulp beside the cut: its surface is known to half a voxel.
TEST(ReachWatchTest, ThePulpIsAsFarAsABallBesideTheCutIs) {
  constexpr double kBall_m = 0.8e-3;
  dvec3 middle(2.6e-3, 0, -1.2e-3);
  Volume block = Block([&](const dvec3& p) { return glm::length(p - middle) < kBall_m; });
  render::Reach reach = After(block, Cut(block, {1e-3, 0.6e-3, 0}, 1.4e-3));
  EXPECT_NEAR(*reach.pulp_mm, 2.6 - 1.0 - 0.8, 0.05);
}

TEST(ReachWatchTest, APulpThatWasOpenedHasNothingLeftOverIt) {
  Volume block = Block(BelowThreeMillimetres);
  EXPECT_NEAR(*After(block, Cut(block, {1e-3, 0.6e-3, 0}, 3.2e-3)).pulp_mm, 0, 0.003);
}

TEST(ReachWatchTest, LookingOftenFindsWhatLookingOnceDoes) {
  Volume block = Block(BelowThreeMillimetres);
  scene::Scene scene = SceneWithTop();
  ReachWatch watch(scene, Target(), block);
  for (double depth_mm : {0.4, 0.9, 1.3, 1.55, 1.8}) {
    watch.Look(Cut(block, {1.4e-3, 0.9e-3, 0}, depth_mm * 1e-3));
  }
  render::Reach once = After(block, Cut(block, {1.4e-3, 0.9e-3, 0}, 1.8e-3));
  EXPECT_DOUBLE_EQ(watch.reach().leeway->left_mm, once.leeway->left_mm);
  EXPECT_DOUBLE_EQ(*watch.reach().pulp_mm, *once.pulp_mm);
}

TEST(ReachWatchTest, WithoutATargetOrPulpThereIsNothingToTell) {
  scene::Scene scene = SceneWithTop();
  Volume block = Block(Nowhere);
  ReachWatch watch(scene, {}, block);
  watch.Look(Cut(block, {1e-3, 0.6e-3, 0}, 1e-3));
  EXPECT_FALSE(watch.reach().leeway.has_value());
  EXPECT_FALSE(watch.reach().pulp_mm.has_value());
}

// In the middle of a disc, far from its outline.
TEST(ReachWatchTest, TooDeepInAShapeIsTheFloorsNotTheOutlines) {
  const Volume initial = Block([](const dvec3&) { return false; });
  scene::CavityTarget target = Target();
  target.half_size_um = {2'500, 2'500, 0};
  scene::PreparationPart disc;
  disc.outline = scene::PreparationPart::Outline::kDisc;
  disc.half_size_um = {2'500, 2'500};
  disc.depth_um = 1'500;
  target.parts = {disc};
  ReachWatch watch(SceneWithTop(), target, initial);
  watch.Look(Cut(initial, {0.7e-3, 0.7e-3, 0}, 1.8e-3));
  const auto leeway = watch.reach().leeway;
  ASSERT_TRUE(leeway.has_value());
  EXPECT_NEAR(leeway->left_mm, 0.25 - 0.3, 0.05);
  EXPECT_EQ(leeway->where, "reach.floor");
}

// A disc's leeway ends around the disc: a box cut within the square around it may be far outside.
TEST(ReachWatchTest, ADiscsLeewayIsMeasuredFromTheDisc) {
  const Volume initial = Block([](const dvec3&) { return false; });
  scene::CavityTarget target = Target();
  target.half_size_um = {1'500, 1'500, 0};
  scene::PreparationPart disc;
  disc.outline = scene::PreparationPart::Outline::kDisc;
  disc.half_size_um = {1'500, 1'500};
  disc.depth_um = 1'500;
  target.parts = {disc};
  ReachWatch watch(SceneWithTop(), target, initial);
  scene::CavityTarget square = target;
  square.parts.clear();
  auto shape = scene::TargetShape(SceneWithTop(), square);
  ASSERT_TRUE(shape.ok());
  watch.Look(scene::Prepared(initial, *shape));
  const auto leeway = watch.reach().leeway;
  ASSERT_TRUE(leeway.has_value());
  // The corner is 1.5 (sqrt 2 - 1) mm outside the disc, known to a voxel.
  EXPECT_NEAR(leeway->left_mm, 0.25 - 0.621, 0.1);
  EXPECT_EQ(leeway->where, "reach.outline");
}

}  // namespace
}  // namespace enamel::station::desk
