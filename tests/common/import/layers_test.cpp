#include "common/import/layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "common/cutting/volume.h"
#include "common/import/import_tooth.h"
#include "shapes.h"
#include "tests/common/import/report_lines.h"

namespace enamel::import {
namespace {

using cutting::Tissue;
using Surfaces = std::array<std::optional<mesh::Triangles>, kLayers>;

double Ball(double r) { return 4.0 / 3 * std::numbers::pi * r * r * r; }
// Part of a ball around the origin above z.
double BallAbove(double r, double z) {
  return std::numbers::pi * (r - z) * (r - z) * (2 * r + z) / 3;
}

double Of(const ImportedScene& s, Tissue t) {
  return cutting::SolidVolume_m3(s.volume)[static_cast<size_t>(t)] * 1e9;
}

// ./check --full: every case also at half the voxel, all signs and distances of each.
bool Full() { return std::getenv("ENAMEL_FULL") != nullptr; }

ImportOptions Coarse(int32_t voxel_nm = 100'000) {
  ImportOptions options{.tooth = 46};
  options.voxel_nm = voxel_nm;
  options.up = "+z";
  return options;
}

// No voxel within `radius` of the centre that is air, or partly.
int AirWithin(const ImportedScene& s, const dvec3& centre_mm, double radius_mm) {
  const auto& spec = s.volume.spec();
  const ivec3 n = spec.voxels();
  int air = 0;
  for (int z = 0; z < n.z; ++z)
    for (int y = 0; y < n.y; ++y)
      for (int x = 0; x < n.x; ++x) {
        const dvec3 p = (spec.origin_m() + spec.voxel_m() * dvec3(x, y, z)) * 1e3 - centre_mm;
        if (Dot(p, p) < radius_mm * radius_mm)
          air += s.volume.PhiAt({x, y, z}) > -cutting::kPhiPerVoxel;
      }
  return air;
}

TEST(LayersTest, NestedSpheresOfDifferentTessellationHaveTheVolumesBetweenThem) {
  auto s =
      ImportLayers({SphereMesh(5, 70), SphereMesh(4, 41), SphereMesh(2, 23)}, "test", Coarse());
  ASSERT_TRUE(s.ok()) << s.status().message();
  EXPECT_NEAR(Of(*s, Tissue::kEnamel) / (Ball(5) - Ball(4)), 1, 0.01);
  EXPECT_NEAR(Of(*s, Tissue::kDentin) / (Ball(4) - Ball(2)), 1, 0.01);
  EXPECT_NEAR(Of(*s, Tissue::kPulp) / Ball(2), 1, 0.02);
  EXPECT_EQ(AirWithin(*s, dvec3(0), 4.7), 0);
}

// An enamel shell, its inner surface of radius 4, around a dentin ball that is smaller or larger.
class ShellTest : public testing::TestWithParam<double> {};

TEST_P(ShellTest, NoAirIsLeftBetweenEnamelAndDentinAndTheyMeetHalfWay) {
  const double apart = GetParam(), middle = 4 - apart / 2;
  if (std::fabs(apart) != 0.05 && !Full()) GTEST_SKIP() << "takes long: ./check --full";
  const mesh::Triangles shell = Joined(SphereMesh(5, 70), Reversed(SphereMesh(4, 61)));
  for (int32_t voxel_nm : {50'000, 100'000}) {
    if (voxel_nm < 100'000 && apart != 0.05 && !Full()) continue;
    auto s = ImportLayers({shell, SphereMesh(4 - apart, 53), SphereMesh(2, 23)}, "test",
                          Coarse(voxel_nm));
    ASSERT_TRUE(s.ok()) << s.status().message();
    EXPECT_EQ(AirWithin(*s, dvec3(0), 4.7), 0) << voxel_nm;
    EXPECT_NEAR(Of(*s, Tissue::kEnamel) / (Ball(5) - Ball(middle)), 1, 0.01) << Lines(*s);
    EXPECT_NEAR(Of(*s, Tissue::kDentin) / (Ball(middle) - Ball(2)), 1, 0.01) << Lines(*s);
    EXPECT_NE(Lines(*s).find("enamel and dentin meet with gaps"), std::string::npos) << Lines(*s);
  }
}

INSTANTIATE_TEST_SUITE_P(GapsAndCrossings, ShellTest,
                         testing::Values(0.05, 0.09, 0.0, -0.05, -0.09));

TEST(LayersTest, SurfacesThatWeaveThroughEachOtherLeaveNoAir) {
  // Offset, so that the gap goes from +0.07 to -0.07 mm around the tooth, and rough besides.
  const mesh::Triangles shell = Joined(SphereMesh(5, 70), Reversed(SphereMesh(4, 61)));
  mesh::Triangles dentin = SphereMesh(4, 67, {0.05, 0.02, -0.04});
  for (dvec3& v : dentin.vertices) v *= 1 + 0.004 * std::sin(19 * v.x) * std::sin(23 * v.y);
  auto s = ImportLayers({shell, dentin, SphereMesh(2, 23)}, "test", Coarse(50'000));
  ASSERT_TRUE(s.ok()) << s.status().message();
  EXPECT_EQ(AirWithin(*s, dvec3(0), 4.7), 0);
  EXPECT_NEAR((Of(*s, Tissue::kEnamel) + Of(*s, Tissue::kDentin) + Of(*s, Tissue::kPulp)) / Ball(5),
              1, 0.003);
}

TEST(LayersTest, WiderGapIsRefusedWithItsFigureAndBridgedWhenAllowed) {
  const Surfaces gaping = {Joined(SphereMesh(5, 60), Reversed(SphereMesh(4, 60))),
                           SphereMesh(3.75, 50), SphereMesh(2, 20)};
  auto refused = ImportLayers(gaping, "test", Coarse());
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.status().message().find("gaps of up to 0.25"), std::string::npos)
      << refused.status().message();
  EXPECT_EQ(refused.status().field(), "bridge_um");
  ImportOptions wide = Coarse();
  wide.bridge_mm = 0.3;
  auto s = ImportLayers(gaping, "test", wide);
  ASSERT_TRUE(s.ok()) << s.status().message();
  EXPECT_EQ(AirWithin(*s, dvec3(0), 4.7), 0);
}

TEST(LayersTest, DeepCrossingIsRefusedWithItsFigure) {
  auto refused = ImportLayers({Joined(SphereMesh(5, 60), Reversed(SphereMesh(4, 60))),
                               SphereMesh(4.3, 50), SphereMesh(2, 20)},
                              "test", Coarse());
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.status().message().find("crossings of up to 0.3"), std::string::npos)
      << refused.status().message();
}

TEST(LayersTest, OpenEnamelDomeOverDentinIsEnamelDownToItsRim) {
  const double rim = std::acos(-1.0 / 5);  // the dome ends at z = -1
  const mesh::Triangles dome = RevolvedMesh(Arc(5, 0, 0, rim, 60), 120);
  auto s = ImportLayers({dome, SphereMesh(4, 53), SphereMesh(2, 23)}, "test", Coarse());
  ASSERT_TRUE(s.ok()) << s.status().message();
  EXPECT_NEAR(Of(*s, Tissue::kEnamel) / (BallAbove(5, -1) - BallAbove(4, -1)), 1, 0.015)
      << Lines(*s);
  EXPECT_NEAR(Of(*s, Tissue::kDentin) / (Ball(4) - Ball(2)), 1, 0.01);
  EXPECT_NE(Lines(*s).find("enamel: 1 holes closed"), std::string::npos) << Lines(*s);
}

// Outside, rim and inside of an enamel cap in one closed surface.
mesh::Triangles Cap(double outer, double inner, double rim, bool with_rim) {
  auto profile = Arc(outer, 0, 0, rim, 60);
  auto back = Arc(inner, 0, rim, 0, 50);
  if (!with_rim) return Joined(RevolvedMesh(profile, 120), RevolvedMesh(back, 110));
  profile.insert(profile.end(), back.begin(), back.end());
  return RevolvedMesh(profile, 120);
}

TEST(LayersTest, EnamelCapWithAnInsideMeetsDentinWhetherItsRimIsClosedOrOpen) {
  const double rim = std::numbers::pi / 2;  // a hemisphere
  for (bool with_rim : {true, false}) {
    for (double apart : {-0.05, 0.05}) {
      if ((apart < 0 || !with_rim) && !Full()) continue;
      auto s =
          ImportLayers({Cap(5, 4, rim, with_rim), SphereMesh(4 - apart, 53), SphereMesh(2, 23)},
                       "test", Coarse());
      ASSERT_TRUE(s.ok()) << s.status().message();
      const double inner = 4 - apart / 2;
      EXPECT_NEAR(Of(*s, Tissue::kEnamel) / ((Ball(5) - Ball(inner)) / 2), 1, 0.015)
          << with_rim << apart << Lines(*s);
      // Well above the mouth of the gap; the scene's origin is 2.5 mm above the balls' middle.
      EXPECT_EQ(AirWithin(*s, dvec3(0, 0, 0.6), 1.7), 0) << with_rim << apart;
    }
  }
}

TEST(LayersTest, DentinOpenBelowAndEnamelOpenAtTheSameHeightLeaveNoEnamelUnderneath) {
  const mesh::Triangles enamel = RevolvedMesh(Arc(5, 0, 0, std::numbers::pi / 2, 60), 120);
  for (double z : {-0.05, 0.05}) {
    if (z < 0 && !Full()) continue;
    mesh::Triangles dentin = RevolvedMesh(Arc(4, 0, 0, std::numbers::pi / 2, 50), 110);
    for (dvec3& v : dentin.vertices) v.z += z;
    auto s = ImportLayers({enamel, dentin, SphereMesh(1.2, 23, {0, 0, 1.6})}, "test", Coarse());
    ASSERT_TRUE(s.ok()) << s.status().message();
    EXPECT_NEAR(Of(*s, Tissue::kEnamel) / ((Ball(5) - Ball(4)) / 2), 1, 0.03) << z << Lines(*s);
    const auto& origin = s->volume.spec();
    int enamel_below = 0;
    const ivec3 n = origin.voxels();
    for (int z_ = 0; z_ < n.z; ++z_)
      for (int y = 0; y < n.y; ++y)
        for (int x = 0; x < n.x; ++x) {
          const dvec3 p = (origin.origin_m() + origin.voxel_m() * dvec3(x, y, z_)) * 1e3;
          enamel_below += std::hypot(p.x, p.y) < 3.5 && p.z < -2 &&
                          s->volume.PhiAt({x, y, z_}) < 0 &&
                          s->volume.TissueAt({x, y, z_}) == Tissue::kEnamel;
        }
    EXPECT_EQ(enamel_below, 0) << z;
  }
}

TEST(LayersTest, PulpChamberOfAHollowDentinIsThePulpWhenNoneIsGiven) {
  const mesh::Triangles hollow = Joined(SphereMesh(4, 50), Reversed(SphereMesh(2, 30)));
  auto s = ImportLayers({SphereMesh(5, 60), hollow, std::nullopt}, "test", Coarse());
  ASSERT_TRUE(s.ok()) << s.status().message();
  EXPECT_NEAR(Of(*s, Tissue::kPulp) / Ball(2), 1, 0.02);
  EXPECT_NEAR(Of(*s, Tissue::kDentin) / (Ball(4) - Ball(2)), 1, 0.01);
  EXPECT_NE(Lines(*s).find("hollow in the dentin"), std::string::npos) << Lines(*s);
}

TEST(LayersTest, PulpInAHollowThatItDoesNotFillLeavesNoAirAndNoEnamelAroundIt) {
  const mesh::Triangles hollow = Joined(SphereMesh(4, 50), Reversed(SphereMesh(2.05, 30)));
  auto s = ImportLayers({SphereMesh(5, 60), hollow, SphereMesh(2, 30)}, "test", Coarse());
  ASSERT_TRUE(s.ok()) << s.status().message();
  EXPECT_EQ(AirWithin(*s, dvec3(0), 4.7), 0);
  EXPECT_NEAR(Of(*s, Tissue::kPulp) / Ball(2), 1, 0.02);
  EXPECT_NEAR(Of(*s, Tissue::kEnamel) / (Ball(5) - Ball(4)), 1, 0.01);
}

TEST(LayersTest, PulpThatCrossesTheEnamelStaysPulpAndIsSaid) {
  auto s = ImportLayers({SphereMesh(5, 60), SphereMesh(4, 50), SphereMesh(2, 30, {0, 0, 2.3})},
                        "test", Coarse());
  ASSERT_TRUE(s.ok()) << s.status().message();
  EXPECT_NEAR(Of(*s, Tissue::kPulp) / Ball(2), 1, 0.02);
  EXPECT_NE(Lines(*s).find("pulp reaches out of the dentin by up to 0.29"), std::string::npos)
      << Lines(*s);
}

TEST(LayersTest, RootBelowTheEnamelIsDentinAndTheCrownsMiddleIsTheOrigin) {
  // A ball of dentin with a root of 3 x 9 mm; the enamel dome ends at the root.
  auto profile = Arc(4, 0, 0, 3 * std::numbers::pi / 4, 60);
  profile.push_back({2.8284, -12});
  profile.push_back({0, -12});
  auto s = ImportLayers({RevolvedMesh(Arc(5, 0, 0, std::numbers::pi / 2, 60), 120),
                         RevolvedMesh(profile, 100), SphereMesh(1.5, 23)},
                        "test", Coarse());
  ASSERT_TRUE(s.ok()) << s.status().message();
  const double root = std::numbers::pi * 8 * (12 - 2.8284);
  EXPECT_NEAR(Of(*s, Tissue::kDentin) / (BallAbove(4, -2.8284) + root - Ball(1.5)), 1, 0.01);
  EXPECT_NEAR(s->scene.landmarks.at("occlusal_centre")[2], 2500, 20);  // dome 5 high, its half
}

TEST(LayersTest, EnamelsPlaceOnTheDentinTellsWhichWayIsUp) {
  auto profile = Arc(4, 0, 0, 3 * std::numbers::pi / 4, 40);
  profile.push_back({2.8284, -12});
  profile.push_back({0, -12});
  const mesh::Triangles tooth[2] = {RevolvedMesh(Arc(5, 0, 0, std::numbers::pi / 2, 40), 80),
                                    RevolvedMesh(profile, 80)};
  for (int axis = 0; axis < 3; ++axis) {
    for (double sign : {-1.0, 1.0}) {
      Surfaces surfaces;
      for (size_t i = 0; i < 2; ++i) {
        surfaces[i] = tooth[i];
        for (dvec3& v : surfaces[i]->vertices) {
          const dvec3 p = v;  // z to the axis, x and y kept right-handed
          v[axis] = sign * p.z, v[(axis + 1) % 3] = p.x, v[(axis + 2) % 3] = sign * p.y;
        }
      }
      ImportOptions options = Coarse(200'000);
      options.up = "auto";
      auto s = ImportLayers(surfaces, "test", options);
      ASSERT_TRUE(s.ok()) << s.status().message();
      EXPECT_EQ(s->placement.up[axis], sign);
      EXPECT_EQ(s->placement.by, std::vector{Witness::kEnamel});
    }
  }
}

TEST(LayersTest, SurfacesOfOtherUnitsOrPlacesAreRefusedByName) {
  const mesh::Triangles enamel = SphereMesh(5, 30), dentin = SphereMesh(4, 30);
  auto says = [&](const Surfaces& surfaces, const std::string& what) {
    auto s = ImportLayers(surfaces, "test", Coarse());
    ASSERT_FALSE(s.ok()) << what;
    EXPECT_NE(s.status().message().find(what), std::string::npos) << s.status().message();
  };
  says({enamel, dentin, SphereMesh(0.002, 20)}, "pulp: expected it around or within the dentin");
  says({enamel, dentin, SphereMesh(2, 20, {0, 0, 25})}, "apart from it");
  says({enamel, std::nullopt, SphereMesh(2, 20)}, "dentin: expected a surface");
  says({std::nullopt, dentin, std::nullopt}, "expected a surface of enamel or pulp");
  says({enamel, dentin, mesh::Triangles{}}, "pulp: its surface holds no triangles");
  mesh::Triangles sheet;
  sheet.vertices = {{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}, {0, 0, 0.1}};
  sheet.indices = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  says({enamel, dentin, sheet}, "pulp: this mesh is no solid");
}

TEST(LayersTest, VolumeDoesNotDependOnTheNumberOfThreads) {
  const Surfaces surfaces = {Joined(SphereMesh(5, 40), Reversed(SphereMesh(4, 35))),
                             SphereMesh(3.95, 30), SphereMesh(2, 20)};
  ImportOptions one = Coarse(), three = Coarse();
  one.threads = 1, three.threads = 3;
  auto a = ImportLayers(surfaces, "test", one), b = ImportLayers(surfaces, "test", three);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_TRUE(a->volume == b->volume);
}

}  // namespace
}  // namespace enamel::import
