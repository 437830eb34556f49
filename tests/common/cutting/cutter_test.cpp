#include "common/cutting/cutter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/analytic_volume.h"

namespace enamel::cutting {
namespace {

double RemovedMm3(const RemovedUnits& removed, double voxel_m) {
  int64_t sum = 0;
  for (int64_t r : removed) sum += r;
  return RemovedUnitsToM3(sum, voxel_m) * 1e9;
}

struct SlotCase {
  Bur bur;
  double depth_m;      // of the tip below the surface
  double closed_form_mm3;
};

// Sphere sunk by its radius and moved by L: half a ball's two ends plus a half cylinder. Cylinder
// standing upright, sunk by d and moved by L: d (pi r^2 + 2 r L).
SlotCase SphereSlot(double r, double length) {
  return {{BurShape::kSphere, r, 0}, r,
          (2.0 / 3 * M_PI * r * r * r + 0.5 * M_PI * r * r * length) * 1e9};
}
SlotCase CylinderSlot(double r, double d, double length) {
  return {{BurShape::kCylinder, r, 4e-3}, d, d * (M_PI * r * r + 2 * r * length) * 1e9};
}

double CutSlot(const SlotCase& slot, int32_t voxel_nm, double length, double step_m, Volume* out = nullptr) {
  Volume block = test::Block(voxel_nm, 3e-3, 3e-3);
  block.Reserve();
  Cutter cutter(block, slot.bur);
  RemovedUnits removed{};
  int n = static_cast<int>(std::ceil(length / step_m));
  // Off the grid on purpose.
  for (int i = 0; i <= n; ++i) {
    Pose pose{dvec3(-length / 2 + length * i / n + 7.3e-6, 11.9e-6, -slot.depth_m), Quat{}};
    EXPECT_TRUE(cutter.Cut(pose, removed));
  }
  if (out) *out = block;
  return RemovedMm3(removed, voxel_nm * 1e-9);
}

TEST(CutterTest, RemovedVolumeAgreesWithTheSweptVolume) {
  double length = 2e-3;
  for (const SlotCase& slot : {SphereSlot(0.5e-3, length), CylinderSlot(0.6e-3, 1e-3, length)}) {
    double coarse = std::fabs(CutSlot(slot, 100'000, length, 25e-6) / slot.closed_form_mm3 - 1);
    double fine = std::fabs(CutSlot(slot, 50'000, length, 12.5e-6) / slot.closed_form_mm3 - 1);
    EXPECT_LT(fine, 5e-3);
    EXPECT_LT(coarse, 2e-2);
  }
}

TEST(CutterTest, HoleDoesNotDependOnTheNumberOfPoses) {
  SlotCase slot = SphereSlot(0.5e-3, 2e-3);
  Volume few, many;
  double a = CutSlot(slot, 50'000, 2e-3, 25e-6, &few);
  double b = CutSlot(slot, 50'000, 2e-3, 0.5e-6, &many);
  EXPECT_NEAR(a, b, 1e-3 * slot.closed_form_mm3);
  // Ridges between poses stay below (h/2)^2 / 8r = 0.16 um.
  for (double x = -0.9e-3; x < 0.9e-3; x += 31e-6) {
    dvec3 p(x, 11.9e-6, -0.5e-3);
    EXPECT_NEAR(few.DistanceAt_m(p), many.DistanceAt_m(p), 0.3e-6);
  }
}

TEST(CutterTest, CutAgainAtTheSamePoseChangesNothing) {
  Volume block = test::Block(50'000, 2e-3, 2e-3);
  block.Reserve();
  Cutter cutter(block, {BurShape::kCylinder, 0.5e-3, 4e-3});
  RemovedUnits removed{};
  Pose pose{dvec3(1.1e-5, 0, -0.7e-3), Quat{0.05, 0.1, 0, 1}.Normalised()};
  cutter.Cut(pose, removed);
  EXPECT_FALSE(cutter.touched().empty());
  RemovedUnits again{};
  cutter.Cut(pose, again);
  EXPECT_TRUE(cutter.touched().empty());
  EXPECT_EQ(again, RemovedUnits{});
}

TEST(CutterTest, OneTenthMicrometrePerTickRemovesExactlyWhatTheFaceSweeps) {
  Volume block = test::Block(50'000, 2e-3, 2e-3);
  block.Reserve();
  double r = 0.5e-3;
  Cutter cutter(block, {BurShape::kCylinder, r, 4e-3});
  RemovedUnits start{}, removed{};
  cutter.Cut({dvec3(0, 0, -0.7e-3), Quat{}}, start);
  for (int i = 1; i <= 500; ++i) cutter.Cut({dvec3(0, 0, -0.7e-3 - i * 0.1e-6), Quat{}}, removed);
  EXPECT_NEAR(RemovedMm3(removed, 50e-6), M_PI * r * r * 50e-6 * 1e9, 0.01 * M_PI * r * r * 50e-6 * 1e9);
}

TEST(CutterTest, OutsideTheGridAndInAirNothingHappens) {
  Volume block = test::Block(50'000, 2e-3, 2e-3);
  Volume before = block;
  block.Reserve();
  Cutter cutter(block, {BurShape::kSphere, 0.5e-3, 0});
  RemovedUnits removed{};
  for (dvec3 tip : {dvec3(0, 0, 0.2e-3), dvec3(1, 1, 1), dvec3(-0.5, 0, 0), dvec3(0, 0, -1e6)}) {
    EXPECT_TRUE(cutter.Cut({tip, Quat{}}, removed));
  }
  EXPECT_EQ(removed, RemovedUnits{});
  EXPECT_TRUE(block == before);
}

TEST(CutterTest, RemovalIsBookedToTheTissueThatWasThere) {
  // Enamel above z = -0.5 mm, dentin below, labels per voxel where a brick has both.
  Volume block = test::Block(50'000, 2e-3, 2e-3);
  double h = 50e-6;
  Volume two = block;
  for (int b = 0; b < two.spec().brick_count(); ++b) {
    ivec3 at(b % two.spec().bricks.x, b / two.spec().bricks.x % two.spec().bricks.y,
             b / (two.spec().bricks.x * two.spec().bricks.y));
    std::array<uint8_t, kBrickVoxels> labels;
    std::array<int16_t, kBrickVoxels> phi;
    for (int i = 0; i < kBrickVoxels; ++i) {
      ivec3 v = at * 8 + ivec3(i & 7, (i >> 3) & 7, i >> 6);
      double z = two.spec().origin_m().z + v.z * h;
      labels[i] = static_cast<uint8_t>(z > -0.5e-3 ? Tissue::kEnamel : Tissue::kDentin);
      phi[i] = static_cast<int16_t>(two.PhiAt(v));
    }
    if (two.IsStored(b) || two.UniformTissue(b) != Tissue::kAir) two.SetBrick(b, phi, labels, Tissue::kEnamel);
  }
  two.Reserve();
  double r = 0.5e-3;
  Cutter cutter(two, {BurShape::kCylinder, r, 4e-3});
  RemovedUnits removed{};
  cutter.Cut({dvec3(0, 0, -0.8e-3), Quat{}}, removed);
  double area_mm2 = M_PI * 0.25;
  // The boundary falls between samples: half a voxel of each label either way.
  EXPECT_NEAR(RemovedUnitsToM3(removed[1], h) * 1e9, area_mm2 * 0.5, area_mm2 * 0.03);
  EXPECT_NEAR(RemovedUnitsToM3(removed[2], h) * 1e9, area_mm2 * 0.3, area_mm2 * 0.03);
}

TEST(BurTest, DistanceOfACylinderIsTheClosedFormOnEverySide) {
  Bur bur{BurShape::kCylinder, 1, 4};
  EXPECT_DOUBLE_EQ(bur.Distance(dvec3(3, 0, 2)), 2);
  EXPECT_DOUBLE_EQ(bur.Distance(dvec3(0, 0, -1)), 1);
  EXPECT_DOUBLE_EQ(bur.Distance(dvec3(4, 0, 8)), 5);
  EXPECT_DOUBLE_EQ(bur.Distance(dvec3(0, 0, 2)), -1);
  EXPECT_DOUBLE_EQ(bur.Distance(dvec3(0, 0, 0.25)), -0.25);
}

TEST(BurTest, SurfacePointsLieOnTheSurfaceAndCarryItsWholeArea) {
  for (Bur bur : {Bur{BurShape::kSphere, 0.5e-3, 0}, Bur{BurShape::kCylinder, 0.6e-3, 4e-3}}) {
    double area = 0;
    for (const SurfacePoint& p : SampleSurface(bur, 0.15e-3, 512)) {
      EXPECT_NEAR(bur.Distance(p.position_m), 0, 1e-15);
      EXPECT_NEAR(glm::length(p.normal), 1, 1e-14);
      area += p.area_m2;
    }
    double r = bur.radius_m;
    double exact = bur.shape == BurShape::kSphere ? 4 * M_PI * r * r : 2 * M_PI * r * bur.length_m + M_PI * r * r;
    EXPECT_NEAR(area / exact, 1, 1e-12);
  }
}

}  // namespace
}  // namespace enamel::cutting
