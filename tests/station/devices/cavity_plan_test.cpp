#include "station/devices/cavity_plan.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/scene/builtin/builtin.h"
#include "common/scene/builtin/exercises.h"
#include "common/scene/preparation.h"
#include "station/devices/operators.h"

namespace enamel::station {
namespace {

class CavityPlanTest : public testing::Test {
 protected:
  CavityPlanTest() {
    auto built = scene::BuildBuiltinScene("block", 200'000);
    EXPECT_TRUE(built.ok()) << built.status().message();
    scene_ = built->scene;
    volume_ = std::move(built->volume);
    exercise_ = scene::ClassOneExercise(scene_, {});
    const auto& at = scene_.landmarks.at("occlusal_centre");
    centre_ = dvec3(at[0], at[1], at[2]) * 1e-6;
    box_.walls =
        RectangleOf({centre_.x - 2e-3, centre_.x + 2e-3, centre_.y - 1.2e-3, centre_.y + 1.2e-3});
    box_.floor_m = centre_.z - 2e-3;
  }

  scene::Scene scene_;
  scene::Exercise exercise_;
  cutting::Volume volume_;
  dvec3 centre_{0};
  HollowCut box_;
  cutting::Bur bur_{cutting::BurShape::kCylinder, 0.5e-3, 4e-3};
};

TEST_F(CavityPlanTest, NoStrokeLeavesTheBox) {
  for (bool clockwise : {false, true}) {
    CavityPlanOptions options;
    options.clockwise = clockwise;
    for (const Move& move : PlanCavity(box_, bur_, volume_, options)) {
      const auto* ring = std::get_if<FinishRing>(&move);
      const auto& points = ring ? ring->corners : std::get<Stroke>(move).points;
      for (const dvec3& p : points) {
        dvec3 d = p - centre_;
        EXPECT_LE(std::abs(d.x) + bur_.radius_m, 2e-3 + 1e-9);
        EXPECT_LE(std::abs(d.y) + bur_.radius_m, 1.2e-3 + 1e-9);
        EXPECT_GE(d.z, -2e-3 - 1e-9);
      }
    }
  }
}

TEST_F(CavityPlanTest, RoughingLeavesStockOnWallsAndFloor) {
  CavityPlanOptions options;
  auto plan = PlanCavity(box_, bur_, volume_, options);
  size_t first_ring = 0;
  while (!std::holds_alternative<FinishRing>(plan[first_ring])) ++first_ring;
  ASSERT_GT(first_ring, 3u);
  const auto& entry = std::get<Stroke>(plan[2]);
  for (const dvec3& p : entry.points) {
    EXPECT_LE(std::abs(p.x - centre_.x) + bur_.radius_m, 2e-3 - options.wall_stock_m + 1e-9);
    EXPECT_GE(p.z, box_.floor_m + options.floor_stock_m - 1e-9);
  }
}

TEST_F(CavityPlanTest, FinishingPushesOutwardWhicheverWayItGoesRound) {
  for (bool clockwise : {false, true}) {
    CavityPlanOptions options;
    options.clockwise = clockwise;
    for (const Move& move : PlanCavity(box_, bur_, volume_, options)) {
      const auto* ring = std::get_if<FinishRing>(&move);
      if (ring == nullptr || ring->outward[0].z != 0) continue;
      for (size_t i = 0; i < ring->corners.size(); ++i) {
        dvec3 middle = 0.5 * (ring->corners[i] + ring->corners[(i + 1) % ring->corners.size()]);
        EXPECT_GT(Dot(ring->outward[i], middle - centre_), 0) << "side " << i;
      }
    }
  }
}

TEST_F(CavityPlanTest, HighestSolidIsTheBlocksTop) {
  double top = HighestSolid_m(volume_, {-1e-3, 1e-3, -1e-3, 1e-3});
  EXPECT_NEAR(top, centre_.z, volume_.spec().voxel_m());
}

TEST_F(CavityPlanTest, BoxTooNarrowForTheBurIsRefused) {
  exercise_.target.half_size_um[1] = 600;
  auto profiles = scene::BuiltinProfiles();
  auto device = MakeSimulatedDevice(*FindOperator("dentist"), scene_, exercise_, profiles[0],
                                    core::CoreParams{}, volume_);
  EXPECT_EQ(device.status().code(), Code::kInvalidInput);
  EXPECT_EQ(device.status().field(), "half_size_um");
}

// Highest x of a neighbour on the left of the tooth, and lowest on its right, from a height upward.
Bounds RoomBetweenNeighbours(const cutting::Volume& volume, double z_m) {
  Bounds room{-1, 1, -1, 1};
  const cutting::GridSpec& spec = volume.spec();
  for (int k = 0; k < spec.voxels().z; ++k)
    for (int j = 0; j < spec.voxels().y; ++j)
      for (int i = 0; i < spec.voxels().x; ++i) {
        const dvec3 at = spec.origin_m() + dvec3(i, j, k) * spec.voxel_m();
        if (at.z < z_m || volume.PhiAt({i, j, k}) >= 0) continue;
        if (volume.TissueAt({i, j, k}) != cutting::Tissue::kNeighbour) continue;
        if (at.x < 0) room.x0 = std::max(room.x0, at.x);
        if (at.x > 0) room.x1 = std::min(room.x1, at.x);
      }
  return room;
}

// A hand strays by as much from the line; nearer, the dentist cut the neighbour 0.24 mm deep.
TEST(StumpPlanTest, TheBurKeepsTwoTenthsOfAMillimetreFromTheNeighbours) {
  constexpr double kKept_m = 0.2e-3;
  const auto built = scene::BuildBuiltinScene("molar-class-2", 200'000);
  ASSERT_TRUE(built.ok());
  const scene::Exercise crown = scene::CrownExercise(built->scene, {});
  const auto shape = scene::TargetShape(built->scene, crown.target);
  ASSERT_TRUE(shape.ok());
  const scene::PreparationPart& part = shape->parts.at(0);
  const cutting::Bur bur = crown.bur().metric();
  const double foot_m = (part.top_um[2] - part.depth_um) * 1e-6;
  const Bounds room = RoomBetweenNeighbours(built->volume, foot_m);
  size_t points = 0;
  const PartCut cut{part, [](const glm::dvec2&) { return 0.0; }, 0};
  for (const Move& move : PlanStump(cut, bur, built->volume, {})) {
    const auto* stroke = std::get_if<Stroke>(&move);
    if (stroke == nullptr) continue;
    for (const dvec3& p : stroke->points) {
      ++points;
      EXPECT_GE(p.x - bur.narrow_radius_m - room.x0, kKept_m);
      EXPECT_GE(room.x1 - p.x - bur.narrow_radius_m, kKept_m);
    }
  }
  EXPECT_GT(points, 100u);
}

}  // namespace
}  // namespace enamel::station
