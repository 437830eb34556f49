#include "common/cutting/cutter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/common/cutting/burs.h"
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
  double depth_m;  // of the tip below the surface
  double closed_form_mm3;
};

// Sphere sunk by its radius and moved by L: half a ball's two ends plus a half cylinder. Cylinder
// standing upright, sunk by d and moved by L: d (pi r^2 + 2 r L).
SlotCase SphereSlot(double r, double length) {
  return {{BurShape::kSphere, r, 0},
          r,
          (2.0 / 3 * M_PI * r * r * r + 0.5 * M_PI * r * r * length) * 1e9};
}
SlotCase CylinderSlot(double r, double d, double length) {
  return {{BurShape::kCylinder, r, 4e-3}, d, d * (M_PI * r * r + 2 * r * length) * 1e9};
}

double CutSlot(const SlotCase& slot, int32_t voxel_nm, double length, double step_m,
               Volume* out = nullptr) {
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

// An upright body of revolution moved sideways sweeps its own volume and its outline's area times
// the way. Integrals of the outline's radius at each height by the midpoint rule.
SlotCase AnySlot(const Bur& bur, double length) {
  double depth =
      bur.shape == BurShape::kSphere ? bur.radius_m : std::min(0.8 * bur.length_m, 1.2e-3);
  double volume = 0, outline = 0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    double z = depth * (i + 0.5) / kSteps, lo = 0, hi = 2 * bur.radius_m;
    for (int k = 0; k < 40; ++k) {
      double mid = (lo + hi) / 2;
      (bur.Distance(dvec3(mid, 0, z)) < 0 ? lo : hi) = mid;
    }
    volume += M_PI * lo * lo * depth / kSteps;
    outline += 2 * lo * depth / kSteps;
  }
  return {bur, depth, (volume + outline * length) * 1e9};
}

// Root of the mean square over places relative to the grid and turns of the bur about its axis'
// tilt.
double VolumeError(const SlotCase& slot, int32_t voxel_nm, double length) {
  double sum = 0;
  constexpr int kPlaces = 3;
  for (int i = 0; i < kPlaces; ++i) {
    Volume block = test::Block(voxel_nm, 3.2e-3, 2.2e-3);
    block.Reserve();
    Cutter cutter(block, slot.bur);
    RemovedUnits removed{};
    double h = voxel_nm * 1e-9;
    dvec3 off = dvec3(0.31 * i, 0.47 * i, 0) * h;
    int n = static_cast<int>(std::ceil(length / (0.5 * h)));
    for (int k = 0; k <= n; ++k) {
      EXPECT_TRUE(cutter.Cut(
          {off + dvec3(-length / 2 + length * k / n, 0, -slot.depth_m - 0.29 * i * h), Quat{}},
          removed));
    }
    SlotCase deeper = slot;
    // A deeper place sweeps more: the topmost slice again.
    double slice = 0.29 * i * h, lo = 0, hi = 2 * slot.bur.radius_m;
    for (int k = 0; k < 40; ++k) {
      double mid = (lo + hi) / 2;
      (slot.bur.Distance(dvec3(mid, 0, slot.depth_m + slice / 2)) < 0 ? lo : hi) = mid;
    }
    deeper.closed_form_mm3 += slice * (M_PI * lo * lo + 2 * lo * length) * 1e9;
    double error = RemovedMm3(removed, h) / deeper.closed_form_mm3 - 1;
    sum += error * error;
  }
  return std::sqrt(sum / kPlaces);
}

TEST(CutterTest, RemovedVolumeAgreesWithTheSweptVolumeForEveryShapeAndConverges) {
  EXPECT_NEAR(AnySlot({BurShape::kSphere, 0.5e-3}, 2e-3).closed_form_mm3,
              SphereSlot(0.5e-3, 2e-3).closed_form_mm3, 1e-6);
  EXPECT_NEAR(AnySlot({BurShape::kCylinder, 0.6e-3, 1.5e-3}, 2e-3).closed_form_mm3,
              CylinderSlot(0.6e-3, 1.2e-3, 2e-3).closed_form_mm3, 1e-6);
  double coarse_sum = 0, fine_sum = 0;
  for (const Bur& bur : test::AllBurs()) {
    SlotCase slot = AnySlot(bur, 2e-3);
    double coarse = VolumeError(slot, 100'000, 2e-3), fine = VolumeError(slot, 50'000, 2e-3);
    std::printf("%-14s volume error %.3f %% at 0.1 mm, %.3f %% at 0.05 mm\n",
                std::string(BurShapeName(bur.shape)).c_str(), 100 * coarse, 100 * fine);
    EXPECT_LT(fine, 5e-3) << BurShapeName(bur.shape);
    coarse_sum += coarse;
    fine_sum += fine;
  }
  EXPECT_LT(fine_sum, 0.33 * coarse_sum) << "falling as the square of the voxel would be a quarter";
}

TEST(CutterTest, HalvesOfACutAreTheWholeCut) {
  Volume whole = test::Block(50'000, 3e-3, 3e-3);
  whole.Reserve();
  Volume halves = whole;
  halves.Reserve();
  Bur bur{BurShape::kCylinder, 0.6e-3, 4e-3};
  Cutter a(whole, bur), b(halves, bur);
  RemovedUnits removed_a{}, removed_b{};
  for (int i = 0; i < 100; ++i) {
    Pose pose{dvec3(-1e-3 + i * 20e-6, 3e-6 * i, -2e-3 - 1e-6 * i),
              Quat{0.001 * i, 0.02, 0, 1}.Normalised()};
    EXPECT_TRUE(a.Cut(pose, removed_a));
    EXPECT_TRUE(b.CutLower(pose, removed_b));
    EXPECT_TRUE(b.CutUpper(pose, removed_b));
  }
  EXPECT_EQ(removed_a, removed_b);
  EXPECT_TRUE(whole == halves);
}

// Every visit that is left out because the bur moved away would have changed nothing: a cutter that
// forgets where it was, and so visits all, makes the same hole.
TEST(CutterTest, LeavingOutWhatTheBurMovedAwayFromChangesNothing) {
  for (const Bur& bur : test::AllBurs()) {
    Volume sparing = test::Block(50'000, 3e-3, 3e-3);
    sparing.Reserve();
    Volume all = sparing;
    all.Reserve();
    Cutter cutter(sparing, bur);
    RemovedUnits removed{}, removed_all{};
    for (int i = 0; i < 60; ++i) {
      double t = i * 0.21;
      Pose pose{
          dvec3(0.4e-3 * std::sin(t), 0.3e-3 * std::cos(1.7 * t), -1e-3 + 20e-6 * std::sin(3 * t)),
          Quat{0.05 * std::sin(t), 0.04 * std::cos(t), 0, 1}.Normalised()};
      // Steps of every size, some too long for the comparison with the pose before.
      if (i % 10 > 4) pose.tip_m = dvec3(0.3e-3, 0, -1e-3) + dvec3(1, 0.3, 0.1) * (i % 10 * 7e-6);
      cutter.Cut(pose, removed);
      Cutter(all, bur).Cut(pose, removed_all);
    }
    // One unit of rounding at most, in few samples.
    int64_t difference = removed[1] - removed_all[1];
    EXPECT_LT(std::abs(difference), removed_all[1] / 100'000) << BurShapeName(bur.shape);
    for (int b = 0; b < all.spec().brick_count(); ++b) {
      if (!all.IsStored(b) || !sparing.IsStored(b)) continue;
      for (size_t k = 0; k < kBrickVoxels; ++k)
        ASSERT_NEAR(all.Phi(b).phi[k], sparing.Phi(b).phi[k], 2);
    }
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
  EXPECT_NEAR(RemovedMm3(removed, 50e-6), M_PI * r * r * 50e-6 * 1e9,
              0.01 * M_PI * r * r * 50e-6 * 1e9);
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
    if (two.IsStored(b) || two.UniformTissue(b) != Tissue::kAir)
      two.SetBrick(b, phi, labels, Tissue::kEnamel);
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

}  // namespace
}  // namespace enamel::cutting
