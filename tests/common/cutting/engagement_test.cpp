#include "common/cutting/engagement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/cutting/cutter.h"
#include "tests/support/analytic_volume.h"

namespace enamel::cutting {
namespace {

TissueDamping Enamel(double axial = 6500) {
  TissueDamping b;
  b.lateral[1] = 6500;
  b.axial[1] = axial;
  return b;
}

// A bur that has just cut itself a seat, so that its surface lies on the tooth's.
struct Seat {
  Seat(const Bur& bur, double depth_m, int32_t voxel_nm, const TissueDamping& damping = Enamel())
      : volume(test::Block(voxel_nm, 4e-3, 6e-3)), reader(bur, voxel_nm * 1e-9, damping) {
    volume.Reserve();
    Cutter cutter(volume, bur);
    RemovedUnits removed{};
    Pose pose{dvec3(13e-6, -9e-6, -depth_m), Quat{}};
    cutter.Cut(pose, removed);
    reader.Sample(volume, pose);
  }
  Volume volume;
  EngagementReader reader;
};

// What beta is defined by: a fully sunk cylinder 0.6 x 4 mm moving sideways meets the tissue's B,
// whatever the direction.
TEST(EngagementTest, ReferenceCylinderMovingSidewaysMeetsTheTissuesDamping) {
  Seat seat({BurShape::kCylinder, 0.6e-3, 4e-3}, 4e-3, 50'000);
  for (double turn : {0.0, 0.13, 0.4}) {
    dvec3 d(std::cos(2 * M_PI * turn), std::sin(2 * M_PI * turn), 0);
    Engagement e = seat.reader.Read(d);
    EXPECT_NEAR(glm::dot(d, e.damping_n_s_per_m * d), 6500, 0.03 * 6500);
  }
}

// Axial: the end face alone, integral of (n.d)^2 = pi r^2.
TEST(EngagementTest, PlungeIsResistedByTheEndFaceOnly) {
  Seat seat({BurShape::kCylinder, 0.6e-3, 4e-3}, 2e-3, 50'000);
  dvec3 down(0, 0, -1);
  double expected = 6500 * (M_PI * 0.36e-6) / EngagementReader::kReferenceArea_m2;
  EXPECT_NEAR(glm::dot(down, seat.reader.Read(down).damping_n_s_per_m * down), expected,
              0.03 * expected);
}

// A bur that cuts with its end half as well as with its side is resisted twice as much when it
// plunges, and as before when it moves sideways.
TEST(EngagementTest, AxialDampingCountsForTheEndFaceOnly) {
  Bur bur{BurShape::kCylinder, 0.6e-3, 4e-3};
  Seat same(bur, 2e-3, 50'000), twice(bur, 2e-3, 50'000, Enamel(13000));
  dvec3 down(0, 0, -1), side(1, 0, 0);
  auto along = [](const Seat& seat, const dvec3& d) {
    return glm::dot(d, seat.reader.Read(d).damping_n_s_per_m * d);
  };
  EXPECT_NEAR(along(twice, down) / along(same, down), 2, 1e-9);
  EXPECT_NEAR(along(twice, side) / along(same, side), 1, 1e-9);
}

// Lowered by a quarter of a millimetre at a time, a wall's share of B grows in even steps.
TEST(EngagementTest, DampingGrowsEvenlyWithDepth) {
  double before = 0;
  for (int i = 1; i <= 12; ++i) {
    Seat seat({BurShape::kCylinder, 0.6e-3, 4e-3}, i * 0.25e-3, 50'000);
    double b = seat.reader.Read(dvec3(1, 0, 0)).damping_n_s_per_m.xx;
    EXPECT_NEAR(b - before, 6500 * 0.25 / 4, 0.25 * 6500 * 0.25 / 4) << i;
    before = b;
  }
}

TEST(EngagementTest, ShankAtAWallHasANormalAndNoDamping) {
  // The cutting part is a small ball beside the block's edge; the shank above it is wider and
  // touches.
  Volume block = test::Block(50'000, 2e-3, 6e-3);
  Bur bur{BurShape::kSphere, 0.3e-3};
  bur.shank_radius_m = 0.8e-3;
  bur.neck_m = 0.5e-3;
  EngagementReader reader(bur, 50e-6, Enamel());
  reader.Sample(block, {dvec3(2e-3 + 0.79e-3, 0, -4e-3), Quat{}});
  EXPECT_TRUE(reader.AnyContact());
  Engagement e = reader.Read(dvec3(-1, 0, 0));
  EXPECT_TRUE(e.damping_n_s_per_m.IsZero());
  EXPECT_NEAR(e.shank_normal.x, -1, 0.05);
  EXPECT_EQ(reader.Read(dvec3(1, 0, 0)).shank_normal, dvec3(0)) << "withdrawal is free";
}

TEST(EngagementTest, WithdrawalMeetsNoResistance) {
  Seat seat({BurShape::kSphere, 0.5e-3, 0}, 0.5e-3, 50'000);
  dvec3 up(0, 0, 1);
  Engagement e = seat.reader.Read(up);
  EXPECT_LT(glm::dot(up, e.damping_n_s_per_m * up), 0.02 * 6500);
}

// Half a ball sunk to its equator, moving down: 2 pi r^2 / 3.
TEST(EngagementTest, HalfSunkBallMatchesTheSphereIntegral) {
  Seat seat({BurShape::kSphere, 0.5e-3, 0}, 0.5e-3, 50'000);
  dvec3 down(0, 0, -1);
  double expected = 6500 * (2 * M_PI * 0.25e-6 / 3) / EngagementReader::kReferenceArea_m2;
  EXPECT_NEAR(glm::dot(down, seat.reader.Read(down).damping_n_s_per_m * down), expected,
              0.04 * expected);
}

TEST(EngagementTest, InAirThereIsNothing) {
  Seat seat({BurShape::kSphere, 0.5e-3, 0}, 0.5e-3, 50'000);
  seat.reader.Sample(seat.volume, {dvec3(0, 0, 1e-3), Quat{}});
  EXPECT_FALSE(seat.reader.AnyContact());
  EXPECT_TRUE(seat.reader.Read(dvec3(1, 0, 0)).damping_n_s_per_m.IsZero());
}

}  // namespace
}  // namespace enamel::cutting
