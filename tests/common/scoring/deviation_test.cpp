#include "common/scoring/deviation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

using cutting::Volume;

// A ball in the middle of the block's grid: two concentric ones are equally far apart everywhere.
Volume MakeBall(int32_t voxel_nm, double radius_mm) {
  cutting::GridSpec spec = MakeBlock(200'000).spec();
  spec.bricks = ivec3(dvec3(spec.bricks) * (200'000.0 / voxel_nm)) + 1;
  spec.voxel_nm = voxel_nm;
  Volume out(spec);
  for (int b = 0; b < spec.brick_count(); ++b) {
    ivec3 brick(b % spec.bricks.x, b / spec.bricks.x % spec.bricks.y,
                b / (spec.bricks.x * spec.bricks.y));
    std::array<int16_t, cutting::kBrickVoxels> phi;
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      ivec3 v = brick * 8 + ivec3(i % 8, i / 8 % 8, i / 64);
      dvec3 p = spec.origin_m() + dvec3(v) * spec.voxel_m() - dvec3(0, 0, -2e-3);
      double units =
          (std::sqrt(Dot(p, p)) - radius_mm * 1e-3) / spec.voxel_m() * cutting::kPhiPerVoxel;
      phi[static_cast<size_t>(i)] =
          static_cast<int16_t>(std::lround(std::clamp(units, -32767.0, 32767.0)));
    }
    out.SetBrick(b, phi, {}, cutting::Tissue::kEnamel);
  }
  return out;
}

struct Spread {
  double rms_mm = 0, lowest_mm = 1e9, highest_mm = -1e9;
  size_t untouched = 0;
};

Spread DeviationOf(const Volume& block, const Volume& attempt, const Volume& reference) {
  auto mesh = surface::ExtractSurface(attempt), other = surface::ExtractSurface(reference);
  auto deviation = DeviationPerVertex(mesh, block, attempt, reference, other);
  auto areas = VertexAreas_m2(mesh);
  Spread out;
  double sum = 0, area = 0;
  for (size_t i = 0; i < deviation.size(); ++i) {
    if (std::isnan(deviation[i])) {
      ++out.untouched;
      continue;
    }
    double d = deviation[i] * 1e3;
    sum += areas[i] * d * d;
    area += areas[i];
    out.lowest_mm = std::min(out.lowest_mm, d);
    out.highest_mm = std::max(out.highest_mm, d);
  }
  out.rms_mm = std::sqrt(sum / area);
  return out;
}

class EvenDeviation : public testing::TestWithParam<std::tuple<int32_t, double>> {};

TEST_P(EvenDeviation, IsFoundWithinAQuarterVoxelAndWithItsSign) {
  auto [voxel_nm, d_mm] = GetParam();
  double tolerance = voxel_nm * 1e-6 / 4;
  Volume initial = MakeBall(voxel_nm, 2.3), reference = MakeBall(voxel_nm, 1.913),
         deeper = MakeBall(voxel_nm, 1.913 - d_mm);
  Spread over = DeviationOf(initial, deeper, reference),
         under = DeviationOf(initial, reference, deeper);
  EXPECT_NEAR(over.rms_mm, d_mm, tolerance);
  EXPECT_NEAR(over.lowest_mm, d_mm, tolerance);
  EXPECT_NEAR(over.highest_mm, d_mm, tolerance);
  EXPECT_NEAR(under.rms_mm, d_mm, tolerance);
  EXPECT_NEAR(under.lowest_mm, -d_mm, tolerance);
  EXPECT_NEAR(under.highest_mm, -d_mm, tolerance);
  EXPECT_EQ(over.untouched, 0u);
}

INSTANTIATE_TEST_SUITE_P(Voxels, EvenDeviation,
                         testing::Combine(testing::Values(100'000, 50'000),
                                          testing::Values(0.05, 0.3, 0.777)));

// Skipped vertices must be those that would have been found equal.
TEST(ChangedBricksTest, WhereNothingMayDifferTheDistancesAreTheSame) {
  const Volume block = MakeBlock(100'000);
  const Volume after = CutCavity(block, {});
  const ChangedBricks changed(block, after);
  const CutTest cut(block, after);
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(-0.02, 1.02);
  const dvec3 extent = dvec3(block.spec().voxels()) * block.spec().voxel_m();
  int same = 0, marked = 0;
  for (int i = 0; i < 20'000; ++i) {
    const dvec3 p =
        block.spec().origin_m() + extent * dvec3(unit(random), unit(random), unit(random));
    EXPECT_EQ(cut.At(p), IsCut(block, after, p));
    marked += cut.At(p);
    if (changed.MayDifferAt(p)) continue;
    ++same;
    EXPECT_EQ(block.DistanceAt_m(p), after.DistanceAt_m(p));
  }
  EXPECT_GT(same, 1000);
  EXPECT_GT(marked, 1000);
  const ChangedBricks none(block, block);
  for (int b = 0; b < block.spec().brick_count(); ++b) EXPECT_FALSE(none.Brick(b));
}

// Beyond what is usual the whole surface is asked: the same distance as to its triangles.
TEST(DeviationTest, AFarSurfaceIsFoundToo) {
  const Volume block = MakeBlock(100'000);
  Cavity small;
  small.mesial_mm = -0.7;  // 2.2 mm short of the reference's wall
  const Volume attempt = CutCavity(block, small), reference = CutCavity(block, {});
  const surface::Mesh mine = surface::ExtractSurface(attempt),
                      other = surface::ExtractSurface(reference);
  const auto deviation = DeviationPerVertex(other, block, reference, attempt, mine);
  const surface::DistanceQuery query(mine);
  float most = 0;
  for (size_t i = 0; i < deviation.size(); ++i) {
    if (std::isnan(deviation[i])) continue;
    const double d = query.Distance_m(dvec3(other.position_m[i]), kDeviationLimit_m);
    EXPECT_EQ(std::fabs(deviation[i]), d < 1e-9 ? 0.0f : static_cast<float>(d));
    most = std::max(most, std::fabs(deviation[i]));
  }
  EXPECT_GT(most, 1e-3);
}

TEST(DeviationTest, ACutAgainstItselfIsExactlyZeroWhereverItWasCut) {
  Volume block = MakeBlock(100'000);
  Cavity cavity;
  cavity.turn = 0.1;
  cavity.tilt = 0.05;
  Volume cut = CutCavity(block, cavity);
  Spread s = DeviationOf(block, cut, cut);
  EXPECT_EQ(s.rms_mm, 0);
  EXPECT_EQ(s.lowest_mm, 0);
  EXPECT_EQ(s.highest_mm, 0);
}

TEST(DeviationTest, TheUntouchedSurfaceHasNone) {
  Volume block = MakeBlock(100'000);
  auto mesh = surface::ExtractSurface(block);
  for (float d : DeviationPerVertex(mesh, block, block, block, mesh)) EXPECT_TRUE(std::isnan(d));
}

TEST(DeviationTest, WhatShouldHaveBeenCutAndWasNotIsNegative) {
  Volume block = MakeBlock(100'000);
  Volume reference = CutCavity(block, {});
  Spread s = DeviationOf(block, block, reference);
  // The middle of the untouched top is nearest to a wall: 1.2 mm, and a vertex within half a voxel.
  EXPECT_NEAR(s.lowest_mm, -1.2, 0.05);
  EXPECT_LE(s.highest_mm, 0.0);
}

TEST(DeviationTest, QuantileIsByWeight) {
  EXPECT_EQ(WeightedQuantile({{3, 1}, {1, 1}, {2, 1}}, 0.5), 2);
  EXPECT_EQ(WeightedQuantile({{3, 8}, {1, 1}, {2, 1}}, 0.5), 3);
  EXPECT_EQ(WeightedQuantile({{1, 95}, {7, 5}}, 0.95), 1);
  EXPECT_EQ(WeightedQuantile({}, 0.5), 0);
}

TEST(DeviationTest, VertexAreasAddUpToTheSurface) {
  Volume block = MakeBlock(100'000);
  auto mesh = surface::ExtractSurface(block);
  double sum = 0;
  for (double a : VertexAreas_m2(mesh)) sum += a;
  // 68 mm of edges, each cut off by less than a voxel.
  EXPECT_NEAR(sum * 1e6, 2 * (7 * 6 + 7 * 4 + 6 * 4), 68 * 0.1);
}

TEST(DeviationTest, PartsAreToldByWhereTheyAreAndWhereTheyFace) {
  OpenBox target{dvec3(-1.5e-3, -1.2e-3, -2e-3), dvec3(1.5e-3, 1.2e-3, 0)};
  auto part = [&](dvec3 mm, dvec3 normal) { return PartOf(target, 2e-3, mm * 1e-3, normal); };
  EXPECT_EQ(part({1.5, 0, -1}, {-1, 0, 0}), kMesial);
  EXPECT_EQ(part({-1.8, 0, -1}, {1, 0, 0}), kDistal);
  EXPECT_EQ(part({0, 1.2, -1}, {0, -1, 0}), kBuccal);
  EXPECT_EQ(part({0, -1.2, -1}, {0, 1, 0}), kLingual);
  EXPECT_EQ(part({0, 0, -2.4}, {0, 0, 1}), kFloor);
  EXPECT_EQ(part({0, 0, 0}, {0, 0, 1}), kNoPart) << "the untouched top is no floor";
  EXPECT_EQ(part({1.5, 0, -1}, {1, 0, 0}), kNoPart) << "faces away from the cavity";
  EXPECT_EQ(part({1.5, 0, -1}, {-0.7, 0.7, 0}), kNoPart) << "a corner";
}

}  // namespace
}  // namespace enamel::scoring
