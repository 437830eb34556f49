#include "station/desk/depth_gauge.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/cutting/cutter.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/preparation.h"
#include "common/scene/prepared_target.h"
#include "common/scoring/shape.h"
#include "common/scoring/task.h"
#include "tests/station/desk/english.h"

namespace enamel::station::desk {
namespace {

using cutting::Bur;
using cutting::BurShape;
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

// A volume's surface as the score looks at it.
struct Cut {
  Cut(const Volume& initial, const Volume& volume)
      : mesh(surface::ExtractSurface(volume)),
        cut(scoring::CutVertices(mesh, initial, volume)),
        areas_m2(scoring::VertexAreas_m2(mesh)) {}
  scoring::CutSide side(const Volume& volume) const { return {&volume, &mesh, &cut, &areas_m2}; }

  surface::Mesh mesh;
  std::vector<bool> cut;
  std::vector<double> areas_m2;
};

scene::Scene SceneAt(const char* landmark, scene::PointUm at = {0, 0, 0}) {
  scene::Scene scene;
  scene.landmarks[landmark] = at;
  return scene;
}
scene::CavityTarget TargetAt(const char* landmark, int32_t depth_um = 0) {
  scene::CavityTarget target;
  target.landmark = landmark;
  target.half_size_um = {800, 800, 0};
  target.depth_um = depth_um;
  return target;
}
cutting::Pose At(const dvec3& tip_m) { return {tip_m, {}}; }
// Its top leans away from y by this angle.
cutting::Pose Leaning(const dvec3& tip_m, double angle) {
  return {tip_m, {std::sin(angle / 2), 0, 0, std::cos(angle / 2)}};
}
constexpr Bur kCylinder{.shape = BurShape::kCylinder, .radius_m = 0.3e-3, .length_m = 3e-3};
constexpr Bur kBall{.shape = BurShape::kSphere, .radius_m = 0.3e-3};
// A part with a floor of its own in place of a level one: z = -1 mm + slope x.
scene::CavityTarget Sloped(double slope) {
  scene::CavityTarget target = TargetAt("labial_face", 1'800);
  scene::PreparationPart part;
  part.half_size_um = {800, 800};
  part.depth_um = 1'800;
  part.relief = {800, {3, 1}, {}};
  for (double x_um : {-800, 0, 800}) {
    part.relief.below_um.push_back(static_cast<int32_t>(std::lround(1'000 - slope * x_um)));
  }
  target.parts = {part};
  return target;
}

TEST(DepthGaugeTest, MeasuresACavityFromItsLandmarkAsItsFloorIsScored) {
  const Volume ridge = Ridge();
  const DepthGauge gauge(SceneAt("occlusal_centre"), TargetAt("occlusal_centre", 1'000),
                         {kCylinder}, ridge);
  for (double deep_m : {0.02e-3, 0.4e-3, 0.77e-3, 1.3e-3}) {
    // Nearer to the side than to the top, which must not matter.
    const BurDepth depth = gauge.At(At({0.75e-3, 0, -deep_m}));
    EXPECT_NEAR(*depth.deep_m, deep_m, 1e-9);
    EXPECT_NEAR(*depth.to_floor_m, 1e-3 - deep_m, 1e-7) << "below the floor it is negative";
  }
  EXPECT_FALSE(gauge.At(At({0, 0, 0.1e-3})).deep_m) << "above it";
  EXPECT_FALSE(gauge.At(At({1.2e-3, 0, -1e-3})).deep_m) << "beside it";
  EXPECT_FALSE(gauge.At(At({0.9e-3, 0, -1e-3})).to_floor_m) << "the target has no floor there";
}

// The surface beside a fossa rises away from the point that depths are measured from.
TEST(DepthGaugeTest, ASurfaceThatRisesBesideTheLandmarkAddsNoDepth) {
  constexpr double kRise = 0.5;
  const Volume slope =
      Solid([](const dvec3& p) { return (p.z - kRise * p.x) / std::sqrt(1 + kRise * kRise); });
  const DepthGauge gauge(SceneAt("occlusal_centre"), TargetAt("occlusal_centre", 1'000),
                         {kCylinder}, slope);
  const BurDepth at_floor = gauge.At(At({0.6e-3, 0, -1e-3}));
  EXPECT_NEAR(*at_floor.deep_m, 1e-3, 1e-9) << "0.3 mm more is under the surface";
  EXPECT_NEAR(*at_floor.to_floor_m, 0, 1e-7);
  const BurDepth above = gauge.At(At({0.6e-3, 0, 0.1e-3}));
  EXPECT_FALSE(above.deep_m) << "higher than the landmark";
  EXPECT_NEAR(*above.to_floor_m, 1.1e-3, 1e-7) << "and in the tooth";
}

TEST(DepthGaugeTest, MeasuresTheDeepestPointOfABurThatLeans) {
  const Volume ridge = Ridge();
  const DepthGauge gauge(SceneAt("occlusal_centre"), TargetAt("occlusal_centre", 1'000),
                         {kCylinder, kBall}, ridge);
  constexpr double kAngle = 0.35, kDeep_m = 0.5e-3;
  const cutting::Pose pose = Leaning({0, 0, -kDeep_m}, kAngle);
  EXPECT_NEAR(*gauge.At(pose).deep_m, kDeep_m + 0.3e-3 * std::sin(kAngle), 1e-9);
  EXPECT_NEAR(*gauge.At(pose, 1).deep_m, kDeep_m + 0.3e-3 * (1 - std::cos(kAngle)), 1e-9);
  EXPECT_NEAR(*gauge.At(pose).to_floor_m, 0.5e-3 - 0.3e-3 * std::sin(kAngle), 1e-7);
}

TEST(DepthGaugeTest, AFloorThatSlopesIsMetByThePartOfTheBurThatComesFirst) {
  const Volume ridge = Ridge();
  for (double slope : {0.25, 0.5, 1.0}) {
    const DepthGauge gauge(SceneAt("labial_face"), Sloped(slope), {kCylinder, kBall}, ridge);
    const cutting::Pose pose = At({0.1e-3, 0, -0.4e-3});
    const double over_m = 0.6e-3 - slope * 0.1e-3;
    EXPECT_NEAR(*gauge.At(pose).to_floor_m, over_m - slope * 0.3e-3, 1e-7) << slope;
    const double ball_m = over_m - 0.3e-3 * (std::sqrt(1 + slope * slope) - 1);
    EXPECT_NEAR(*gauge.At(pose, 1).to_floor_m, ball_m, 0.02e-3) << slope;
    EXPECT_NEAR(*gauge.At(pose).deep_m, 0.4e-3, 1e-7) << "under the surface";
  }
}

TEST(DepthGaugeTest, ACrownHasItsShoulderAndItsTableAsFloors) {
  const Volume ridge = Ridge();
  scene::CavityTarget target = TargetAt("crown_top", 1'200);
  target.half_size_um = {1'500, 1'500, 0};
  scene::PreparationPart part;
  part.outline = scene::PreparationPart::Outline::kStump;
  part.half_size_um = {1'500, 1'500};
  part.depth_um = 1'200;
  part.stump = {{{0, 0}, {500, 500}}, {{0, 0}, {450, 450}}, 400, 0};
  target.parts = {part};
  const DepthGauge gauge(SceneAt("crown_top"), target, {kCylinder}, ridge);
  EXPECT_NEAR(*gauge.At(At({0.85e-3, 0, -1e-3})).to_floor_m, 0.2e-3, 1e-7);
  EXPECT_NEAR(*gauge.At(At({0, 0, -0.3e-3})).to_floor_m, 0.1e-3, 1e-7);
  target.parts.clear();
  const DepthGauge unknown(SceneAt("crown_top"), target, {kCylinder}, ridge);
  EXPECT_FALSE(unknown.At(At({0, 0, -0.3e-3})).to_floor_m) << "nobody knows what stands";
}

TEST(DepthGaugeTest, TheFloorOfAPreparedToothIsItsOwn) {
  const Volume ridge = Ridge();
  auto tooth = std::make_shared<scene::PreparedTooth>();
  // A groove with a level floor, along y.
  tooth->volume = Solid([](const dvec3& p) {
    const double groove = std::max(std::abs(p.x) - 0.5e-3, -0.8e-3 - p.z);
    return std::max(std::max(p.z, std::abs(p.x) - 1e-3), -groove);
  });
  scene::CavityTarget target = TargetAt("occlusal_centre", 800);
  target.prepared = HashSha256({});
  target.prepared_tooth = tooth;
  const DepthGauge gauge(SceneAt("occlusal_centre"), target, {kCylinder}, ridge);
  const BurDepth in = gauge.At(At({0.1e-3, 0, -0.3e-3}));
  EXPECT_NEAR(*in.to_floor_m, 0.5e-3, 1e-6);
  EXPECT_NEAR(*in.deep_m, 0.3e-3, 1e-7);
  EXPECT_NEAR(*gauge.At(At({0.1e-3, 0, -1e-3})).to_floor_m, -0.2e-3, 1e-6);
  EXPECT_FALSE(gauge.At(At({0.85e-3, 0, -0.3e-3})).to_floor_m) << "beside the groove";
}

// The figure beside the bur equals the deviation that the floor criterion reports for the cut.
TEST(DepthGaugeTest, SaysOfTheFloorWhatTheScoreSays) {
  for (const char* name : {"block", "molar"}) {
    auto built = scene::BuildBuiltinScene(name, 200'000);
    ASSERT_TRUE(built.ok());
    const Volume& initial = built->volume;
    const scene::CavityTarget target = scene::ClassOneExercise(built->scene, {}).target;
    const auto boxes = scoring::BoxesOf(built->scene, target);
    ASSERT_TRUE(boxes.ok());
    const scoring::OpenBox& box = boxes->target;
    const Volume wanted = scene::Prepared(initial, *scene::TargetShape(built->scene, target));
    const Cut reference(initial, wanted);
    const Bur bur{.shape = BurShape::kCylinder, .radius_m = 0.5e-3, .length_m = 4e-3};
    const DepthGauge gauge(built->scene, target, {bur}, initial);
    for (double left_m : {0.3e-3, 0.0, -0.2e-3}) {
      Volume volume = initial;
      volume.Reserve();
      cutting::Cutter cutter(volume, bur);
      cutting::RemovedUnits removed{};
      const double z_m = box.lo_m.z + left_m, r = bur.radius_m;
      double most_m = -1, least_m = 1;
      for (double y = box.lo_m.y + r; y <= box.hi_m.y - r + 1e-9; y += 0.1e-3) {
        for (double x = box.lo_m.x + r; x <= box.hi_m.x - r + 1e-9; x += 0.1e-3) {
          ASSERT_TRUE(cutter.Cut(At({x, y, z_m}), removed));
          const BurDepth depth = gauge.At(At({x, y, z_m}));
          EXPECT_NEAR(*depth.deep_m + *depth.to_floor_m, target.depth_um * 1e-6, 1e-7);
          most_m = std::max(most_m, *depth.to_floor_m);
          least_m = std::min(least_m, *depth.to_floor_m);
        }
      }
      EXPECT_NEAR(most_m, least_m, 1e-7) << "wherever the bur is on the floor";
      const Cut made(initial, volume);
      const auto back =
          scoring::DeviationPerVertex(reference.mesh, initial, wanted, volume, made.mesh);
      const auto walls = scoring::MeasureWalls(initial, made.side(volume), reference.side(wanted),
                                               back, box, target.depth_um * 1e-6);
      // The score's floor is known to some hundredths of a voxel, the figure beside the bur to one.
      EXPECT_NEAR(most_m, -walls[scoring::kFloor].offset_m, 0.01e-3) << name << " " << left_m;
    }
  }
}

TEST(DepthGaugeTest, MeasuresACrownFromItsSidesToo) {
  const Volume ridge = Ridge();
  const scene::Scene scene = SceneAt("crown_top");
  const DepthGauge gauge(scene, TargetAt("crown_top"), {kCylinder}, ridge);
  EXPECT_NEAR(*gauge.At(At({0.8e-3, 0, -1.2e-3})).deep_m, 0.2e-3, 1e-8);
  EXPECT_NEAR(*gauge.At(At({0, 0, -0.3e-3})).deep_m, 0.3e-3, 1e-8);
  // At most 8 % too much, whatever the surface faces.
  constexpr double kBall_m = 1.2e-3, kDeep_m = 0.6e-3;
  const Volume ball = Solid([](const dvec3& p) { return glm::length(p) - kBall_m; });
  const DepthGauge on_ball(scene, TargetAt("crown_top"), {kCylinder}, ball);
  for (int i = 0; i < 24; ++i) {
    const double a = i * 0.1309;  // 7.5 degrees, over half a turn
    const dvec3 p = (kBall_m - kDeep_m) * dvec3(std::cos(a), 0, std::sin(a));
    const double depth_m = *on_ball.At(At(p)).deep_m;
    EXPECT_GE(depth_m, kDeep_m - 1e-6) << i;
    EXPECT_LE(depth_m, 1.08 * kDeep_m) << i;
  }
}

TEST(DepthGaugeTest, WritesNoMoreThanTheVoxelsGive) {
  const Volume ridge = Ridge();
  const DepthGauge gauge(SceneAt("occlusal_centre"), TargetAt("occlusal_centre"), {}, ridge);
  EXPECT_EQ(gauge.Text(kEnglish, {1.3626e-3, 0.6374e-3}), "1.35 mm deep\n0.65 mm to the floor");
  EXPECT_EQ(gauge.Text(kEnglish, {2.01e-3, -0.01e-3}), "2.00 mm deep\nat the floor");
  EXPECT_EQ(gauge.Text(kEnglish, {2.1e-3, -0.1e-3}), "2.10 mm deep\n0.10 mm below the floor");
  EXPECT_EQ(gauge.Text(kEnglish, {{}, 2.1e-3}), "2.10 mm to the floor");
  EXPECT_EQ(gauge.Text(kEnglish, {0.01e-3, {}}), "0.00 mm deep");
  EXPECT_EQ(gauge.Text(kEnglish, {}), "");
  const Volume coarse(GridSpec{150'000, {1, 1, 1}, {0, 0, 0}});
  const DepthGauge on_coarse(SceneAt("occlusal_centre"), TargetAt("occlusal_centre"), {}, coarse);
  EXPECT_EQ(on_coarse.Text(kEnglish, {1.3626e-3, {}}), "1.4 mm deep");
}

}  // namespace
}  // namespace enamel::station::desk
