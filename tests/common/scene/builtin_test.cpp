#include "common/scene/builtin.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/json.h"
#include "common/scene/molar.h"
#include "common/scene/volume_blob.h"

namespace enamel::scene {
namespace {

using cutting::Tissue;

const BuiltScene& Molar() {
  static const BuiltScene scene = *BuildBuiltinScene("molar", 100'000);
  return scene;
}

dvec3 Landmark_m(const Scene& s) {
  const PointUm& p = s.landmarks.at("occlusal_centre");
  return dvec3(p[0], p[1], p[2]) * 1e-6;
}

// Height of the first solid below (x, y), mm; NaN when there is none.
double SurfaceHeight_mm(double x_mm, double y_mm) {
  for (double z = 5; z > -4; z -= 0.01) {
    if (MolarField(dvec3(x_mm, y_mm, z) * 1e-3).distance_m < 0) return z;
  }
  return std::nan("");
}

TEST(MolarTest, VolumeHashNamesTheVolumeAndDocumentReadsBack) {
  EXPECT_EQ(Molar().scene.volume, HashSha256(EncodeVolume(Molar().volume)));
  EXPECT_TRUE(SceneFromJson(ToJson(Molar().scene)).ok());
}

TEST(MolarTest, LandmarkIsOnTheSurfaceAtTheBottomOfTheFossa) {
  dvec3 p = Landmark_m(Molar().scene);
  EXPECT_NEAR(Molar().volume.DistanceAt_m(p), 0, 20e-6);
  for (double dx : {-0.3, 0.3})
    EXPECT_GT(SurfaceHeight_mm(p.x * 1e3 + dx, p.y * 1e3), p.z * 1e3 - 0.01);
  for (double dy : {-0.3, 0.3})
    EXPECT_GT(SurfaceHeight_mm(p.x * 1e3, p.y * 1e3 + dy), p.z * 1e3 + 0.05);
}

TEST(MolarTest, FieldIsATrueDistanceNearTheSurface) {
  // Walking the stated distance along the field's gradient must end on the surface.
  int tested = 0, far_off = 0;
  for (double x = -5.4; x < 5.5; x += 0.37)
    for (double y = -5; y < 5.1; y += 0.41)
      for (double z = -17.5; z < 4; z += 0.29) {
        dvec3 p = dvec3(x, y, z) * 1e-3;
        double d = MolarField(p).distance_m;
        if (std::abs(d) > 0.2e-3) continue;
        dvec3 g;
        for (int i = 0; i < 3; ++i) {
          dvec3 step(0);
          step[i] = 5e-6;
          g[i] = MolarField(p + step).distance_m - MolarField(p - step).distance_m;
        }
        g /= std::sqrt(Dot(g, g));
        ++tested;
        far_off += std::abs(MolarField(p - d * g).distance_m) > 10e-6;
      }
  EXPECT_GT(tested, 1000);
  // Fissures and the furcation have no single gradient.
  EXPECT_LT(far_off, tested / 20);
}

TEST(MolarTest, HasFiveCuspsAboveTheFossa) {
  double fossa = Landmark_m(Molar().scene).z * 1e3;
  const double cusps[5][2] = {
      {2.35, 2.65}, {-0.95, 2.75}, {-3.75, 1.35}, {2.25, -2.6}, {-1.95, -2.65}};
  for (const auto& c : cusps) EXPECT_GT(SurfaceHeight_mm(c[0], c[1]), fossa + 0.5);
  EXPECT_LT(SurfaceHeight_mm(0.7, 2.7), SurfaceHeight_mm(2.35, 2.65) - 0.4);    // buccal groove
  EXPECT_LT(SurfaceHeight_mm(0.15, -2.6), SurfaceHeight_mm(2.25, -2.6) - 0.4);  // lingual groove
}

TEST(MolarTest, EnamelIsThickAtTheCuspsAndEndsAtTheCervicalLine) {
  for (double x : {2.3, -1.9}) {
    double top = SurfaceHeight_mm(x, -2.6), z = top - 0.05;
    while (MolarField(dvec3(x, -2.6, z) * 1e-3).tissue == Tissue::kEnamel) z -= 0.01;
    EXPECT_GT(top - z, 1.8);
    EXPECT_LT(top - z, 3.0);
  }
  for (double y : {-4.5, -3.0, 0.0, 3.0, 4.5}) {
    EXPECT_NE(MolarField(dvec3(0, y, -4.2) * 1e-3).tissue, Tissue::kEnamel);
  }
}

TEST(MolarTest, ClassOneCavityLeavesAtLeastHalfAMillimetreOfDentinOverThePulp) {
  Exercise e = ClassOneExercise(Molar().scene, {});
  dvec3 c = Landmark_m(Molar().scene);
  double floor = c.z - (e.target.depth_um + e.target.leeway_bottom_um) * 1e-6 - 0.5e-3;
  double hx = (e.target.half_size_um[0] + e.target.leeway_side_um) * 1e-6 + 0.5e-3;
  double hy = (e.target.half_size_um[1] + e.target.leeway_side_um) * 1e-6 + 0.5e-3;
  for (double x = -hx; x <= hx; x += 0.1e-3)
    for (double y = -hy; y <= hy; y += 0.1e-3)
      for (double z = floor; z < c.z; z += 0.2e-3) {
        ASSERT_NE(MolarField({c.x + x, c.y + y, z}).tissue, Tissue::kPulp)
            << x << " " << y << " " << z;
      }
}

TEST(MolarTest, CrownAndRootsHaveTheStatedSize) {
  dvec3 lo(1), hi(-1);
  for (double x = -5.8; x < 5.8; x += 0.1)
    for (double y = -5.6; y < 5.6; y += 0.1)
      for (double z = -18.1; z < 4.4; z += 0.1) {
        dvec3 p = dvec3(x, y, z) * 1e-3;
        if (MolarField(p).distance_m > 0) continue;
        lo = glm::min(lo, p);
        hi = glm::max(hi, p);
      }
  EXPECT_NEAR(hi.x - lo.x, 11e-3, 0.5e-3);
  EXPECT_NEAR(hi.y - lo.y, 10e-3, 0.5e-3);
  EXPECT_NEAR(hi.z - -3.75e-3, 7.5e-3, 0.5e-3);
  EXPECT_NEAR(-3.75e-3 - lo.z, 14e-3, 0.5e-3);
}

TEST(BlockTest, VolumeIsThatOfTheBox) {
  auto block = BuildBuiltinScene("block", 200'000);
  ASSERT_TRUE(block.ok());
  auto v = cutting::SolidVolume_m3(block->volume);
  EXPECT_NEAR(v[static_cast<size_t>(Tissue::kGypsum)] * 1e9, 4000, 4);
}

TEST(BuiltinTest, UnknownNameListsTheKnownOnes) {
  auto none = BuildBuiltinScene("incisor", 100'000);
  EXPECT_EQ(none.status().code(), Code::kNotFound);
  EXPECT_NE(none.status().message().find("molar, block"), std::string::npos);
}

TEST(BuiltinTest, ClassOneRubricHasOneHundredPoints) {
  double sum = 0;
  for (const auto& c : ClassOneExercise(Molar().scene, {}).rubric.criteria) sum += c.points;
  EXPECT_EQ(sum, 100);
}

}  // namespace
}  // namespace enamel::scene
