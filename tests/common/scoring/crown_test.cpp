#include "common/scoring/crown.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/scene/builder.h"
#include "common/scoring/task.h"

// A round tooth of 4.5 mm radius, 7 mm above its shoulder, and stumps in it in closed form.
namespace enamel::scoring {
namespace {

double Slope(double degrees) { return std::tan(degrees * std::numbers::pi / 180); }
double Degrees(double slope) { return std::atan(slope) * 180 / std::numbers::pi; }

constexpr double kTooth_mm = 4.5, kToothTop_mm = 7, kStumpTop_mm = 5.5, kFoot_mm = 3.6;

struct StumpShape {
  double taper_deg = 6;       // of each wall
  double lean_deg = 0;        // of the stump, mesially
  double foot_mm = kFoot_mm;  // radius at the shoulder
  double top_mm = kStumpTop_mm;
  double shoulder_mm = 0, wave_mm = 0;  // height, and that of four waves around it
  double bevel_mm = 0;                  // off the top's edge at 45 degrees, so far in on the top
  double narrows = 0;                   // of the tooth's radius, to a mm below height 0
  double eightfold_deg = 0;             // how much the taper differs, eight times around
  double pit_mm = 0;                    // radius of a ball that is taken out of the mesial wall
  bool cut = true;
};

double Distance_mm(const StumpShape& s, const dvec3& p) {
  const double side = std::hypot(p.x, p.y) - kTooth_mm - s.narrows * std::min(0.0, p.z);
  const double tooth = std::max(side / std::sqrt(1 + s.narrows * s.narrows), p.z - kToothTop_mm);
  if (!s.cut) return tooth;
  const double floor = s.shoulder_mm + s.wave_mm * std::sin(4 * std::atan2(p.y, p.x));
  const double rise = p.z - s.shoulder_mm;
  const double rho = std::hypot(p.x - Slope(s.lean_deg) * rise, p.y);
  const double slope = Slope(s.taper_deg + s.eightfold_deg * std::cos(8 * std::atan2(p.y, p.x)));
  const double wall = (rho - s.foot_mm + slope * rise) / std::sqrt(1 + slope * slope);
  double stump = std::max(wall, p.z - s.top_mm);
  if (s.bevel_mm > 0) {
    const double edge = s.foot_mm - Slope(s.taper_deg) * (s.top_mm - s.shoulder_mm);
    stump = std::max(stump, (rho - edge + s.bevel_mm + p.z - s.top_mm) / std::sqrt(2.0));
  }
  const double prepared = std::max(tooth, std::min(stump, p.z - floor));
  if (s.pit_mm == 0) return prepared;
  return std::max(prepared, s.pit_mm - std::hypot(p.x - 3.3, p.y, p.z - 2));
}

struct Tooth {
  cutting::Volume volume;
  surface::Mesh mesh;
  std::vector<bool> cut;
  std::vector<double> areas_m2;

  CutSide side() const { return {&volume, &mesh, &cut, &areas_m2}; }
};

cutting::Volume MakeTooth(const StumpShape& shape, int32_t voxel_nm) {
  cutting::GridSpec spec;
  spec.voxel_nm = voxel_nm;
  spec.origin_nm = {-5'013'000, -5'021'000, -3'017'000};
  const int bricks = static_cast<int>(10.4e6 / (cutting::kBrickSide * voxel_nm)) + 1;
  spec.bricks = ivec3(bricks, bricks, bricks);
  return scene::BuildVolume(spec, [&](const dvec3& p) -> scene::FieldSample {
    return {Distance_mm(shape, p * 1e3) * 1e-3, cutting::Tissue::kDentin};
  });
}

Tooth Make(const StumpShape& shape, const cutting::Volume& initial) {
  Tooth out{MakeTooth(shape, initial.spec().voxel_nm), {}, {}, {}};
  out.mesh = surface::ExtractSurface(out.volume);
  out.cut = CutVertices(out.mesh, initial, out.volume);
  out.areas_m2 = VertexAreas_m2(out.mesh);
  return out;
}

class CrownTest : public testing::TestWithParam<int32_t> {
 protected:
  CrownFigures Measure(const StumpShape& attempt, int mesial_x = 1) {
    const Tooth made = Make(attempt, initial_);
    return MeasureCrown(initial_, made.side(), reference_.side(), dvec3(0, 0, 5e-3), 0.2e-3,
                        mesial_x);
  }
  double quarter_m() const { return GetParam() * 1e-9 / 4; }

  const cutting::Volume initial_ = MakeTooth({.cut = false}, GetParam());
  const Tooth reference_ = Make({}, initial_);
};

TEST_P(CrownTest, ReferenceIsFoundAsItWasMade) {
  const CrownFigures f = Measure({});
  ASSERT_TRUE(f.made);
  for (double deg : {f.mesiodistal_deg, f.buccolingual_deg, f.least_deg, f.most_deg}) {
    EXPECT_NEAR(deg, 12, 0.5);
  }
  EXPECT_NEAR(f.axis_deg, 0, 0.25);
  EXPECT_EQ(f.undercut_m2, 0);
  EXPECT_EQ(f.depth_m, 0);
  EXPECT_EQ(f.waviness_m, 0);
  EXPECT_EQ(f.complete, 1);
  // Walls: from 0.5 mm above the shoulder to 0.5 mm below the top, at their middle.
  const double wall = kTooth_mm - kFoot_mm + Slope(6) * kStumpTop_mm / 2;
  for (double m : f.wall_m) EXPECT_NEAR(m, wall * 1e-3, quarter_m());
  EXPECT_NEAR(f.top_m, (kToothTop_mm - kStumpTop_mm) * 1e-3, quarter_m());
  EXPECT_NEAR(f.top_least_m, f.top_m, quarter_m());
  const double width = kTooth_mm - kFoot_mm + Slope(6) * 0.3;
  EXPECT_NEAR(f.width_m, width * 1e-3, quarter_m());
  EXPECT_NEAR(f.width_least_m, width * 1e-3, quarter_m());
}

TEST_P(CrownTest, ConvergenceFollowsTheWalls) {
  for (double taper : {-3.0, 0.0, 2.0, 15.0}) {
    const CrownFigures f = Measure({.taper_deg = taper});
    ASSERT_TRUE(f.made) << taper;
    EXPECT_NEAR(f.mesiodistal_deg, 2 * taper, 0.5);
    EXPECT_NEAR(f.least_deg, 2 * taper, 0.5);
    EXPECT_NEAR(f.most_deg, 2 * taper, 0.5);
  }
}

// From the top of the walls to the finish line, whose edges are round.
TEST_P(CrownTest, TheOverhangIsThatOfTheWholeWall) {
  for (double taper : {-1.0, -3.0}) {
    const double overhang_mm = 2 * Slope(-taper) * kStumpTop_mm;
    EXPECT_NEAR(Measure({.taper_deg = taper}).overhang_m, overhang_mm * 1e-3, 2 * quarter_m());
  }
  EXPECT_EQ(Measure({}).overhang_m, 0);
}

TEST_P(CrownTest, APitInAWallIsNoLeanAndNoOverhang) {
  const CrownFigures f = Measure({.pit_mm = 0.8});
  ASSERT_TRUE(f.made);
  EXPECT_NEAR(f.mesiodistal_deg, 12, 0.5);
  EXPECT_NEAR(f.axis_deg, 0, 0.25);
  EXPECT_EQ(f.overhang_m, 0);
}

// Every 45 degrees its walls are alike, and steeper half way between.
TEST_P(CrownTest, SectionsAreLookedAtEvery22Degrees) {
  const CrownFigures f = Measure({.taper_deg = 6, .eightfold_deg = 4});
  ASSERT_TRUE(f.made);
  EXPECT_NEAR(f.mesiodistal_deg, 20, 0.5);
  EXPECT_NEAR(f.buccolingual_deg, 20, 0.5);
  EXPECT_NEAR(f.most_deg, 20, 0.5);
  EXPECT_NEAR(f.least_deg, 4, 0.5);
}

TEST_P(CrownTest, ADeeperFinishLineIsFoundWhereTheToothIsNarrower) {
  const cutting::Volume tooth = MakeTooth({.narrows = 0.6, .cut = false}, GetParam());
  const Tooth asked = Make({.narrows = 0.6}, tooth);
  for (double mm : {0.3, 0.6, 1.0}) {
    const Tooth made = Make({.shoulder_mm = -mm, .narrows = 0.6}, tooth);
    const CrownFigures f =
        MeasureCrown(tooth, made.side(), asked.side(), dvec3(0, 0, 5e-3), 0.2e-3, 1);
    ASSERT_TRUE(f.made) << mm;
    EXPECT_NEAR(f.depth_m, mm * 1e-3, quarter_m()) << mm;
    EXPECT_NEAR(f.waviness_m, 0, quarter_m()) << mm;
  }
}

TEST_P(CrownTest, LeaningStumpHasALeanAndHardlyAnotherConvergence) {
  const CrownFigures f = Measure({.taper_deg = 8, .lean_deg = 5});
  ASSERT_TRUE(f.made);
  const double mesial = Degrees(Slope(8) - Slope(5)), distal = Degrees(Slope(8) + Slope(5));
  EXPECT_NEAR(f.mesiodistal_deg, mesial + distal, 0.5);
  EXPECT_NEAR(f.axis_deg, (distal - mesial) / 2, 0.5);
  // In a tooth whose mesial side is at -x it leans distally.
  const CrownFigures other = Measure({.taper_deg = 8, .lean_deg = 5}, -1);
  EXPECT_EQ(other.wall_m[kMesial], f.wall_m[kDistal]);
  EXPECT_EQ(other.wall_m[kDistal], f.wall_m[kMesial]);
  EXPECT_NE(f.wall_m[kMesial], f.wall_m[kDistal]);
  EXPECT_EQ(other.mesiodistal_deg, f.mesiodistal_deg);
  EXPECT_EQ(other.axis_deg, f.axis_deg);
}

TEST_P(CrownTest, UndercutIsTheAreaThatLeansOut) {
  const double taper = -6;
  const CrownFigures f = Measure({.taper_deg = taper, .foot_mm = 3});
  ASSERT_TRUE(f.made);
  const double height = kStumpTop_mm - 1, radius = 3 - Slope(taper) * kStumpTop_mm / 2;
  const double area_mm2 =
      2 * std::numbers::pi * radius * height / std::cos(taper * std::numbers::pi / 180);
  EXPECT_NEAR(f.undercut_m2 * 1e6, area_mm2, 0.06 * area_mm2);
  EXPECT_LT(f.least_deg, -11);
  EXPECT_EQ(Measure({.taper_deg = 0}).undercut_m2, 0) << "upright is not undercut";
}

TEST_P(CrownTest, WidthReductionAndFinishLineAreFoundWithinAQuarterVoxel) {
  const CrownFigures narrow = Measure({.foot_mm = 4.1});
  EXPECT_NEAR(narrow.width_m, (0.4 + Slope(6) * 0.3) * 1e-3, quarter_m());
  EXPECT_EQ(narrow.complete, 1);
  EXPECT_LT(Measure({.foot_mm = 4.4}).complete, 0.1) << "0.13 mm is no finish line";
  const CrownFigures low = Measure({.top_mm = 5});
  EXPECT_NEAR(low.top_m, 2e-3, quarter_m());
  for (double mm : {-0.3, -0.1, 0.1, 0.3}) {
    EXPECT_NEAR(Measure({.shoulder_mm = mm}).depth_m, -mm * 1e-3, quarter_m()) << mm;
  }
  const CrownFigures wavy = Measure({.wave_mm = 0.2});
  EXPECT_NEAR(wavy.waviness_m, 0.2e-3 / std::sqrt(2), quarter_m());
  EXPECT_NEAR(wavy.depth_m, 0, quarter_m());
}

// The bevel of a mesh in the metric's sector: its area over the arc's length.
double MeshBevel_mm(const surface::Mesh& mesh, const std::vector<double>& areas_m2) {
  double area = 0, radius = 0;
  for (size_t i = 0; i < mesh.position_m.size(); ++i) {
    const dvec3 p(mesh.position_m[i]);
    if (std::fabs(std::atan2(p.x, p.y)) > 25 * std::numbers::pi / 180 || p.z < 2e-3) continue;
    if (mesh.normal[i].z < std::cos(65 * std::numbers::pi / 180) ||
        mesh.normal[i].z > std::cos(std::numbers::pi / 6)) {
      continue;
    }
    area += areas_m2[i];
    radius += areas_m2[i] * std::hypot(p.x, p.y);
  }
  return 1e3 * area / (radius / area * 50 * std::numbers::pi / 180);
}

TEST_P(CrownTest, BevelIsAsWideAsItWasCut) {
  EXPECT_FALSE(Measure({}).bevel_buccal.made) << "a flat top has none";
  for (double bevel : {0.5, 1.0}) {
    const Tooth made = Make({.bevel_mm = bevel}, initial_);
    const CrownFigures f =
        MeasureCrown(initial_, made.side(), reference_.side(), dvec3(0, 0, 5e-3), 0.2e-3, 1);
    ASSERT_TRUE(f.bevel_buccal.made && f.bevel_lingual.made);
    const double width = std::sqrt(2.0) * bevel / (1 - Slope(6));
    EXPECT_NEAR(f.bevel_buccal.width_m * 1e3, width, 4 * quarter_m() * 1e3);
    EXPECT_NEAR(f.bevel_lingual.width_m * 1e3, width, 4 * quarter_m() * 1e3);
    EXPECT_NEAR(f.bevel_buccal.angle_deg, 45, 2);
    EXPECT_NEAR(f.bevel_buccal.width_m * 1e3, MeshBevel_mm(made.mesh, made.areas_m2),
                6 * quarter_m() * 1e3);
  }
}

TEST_P(CrownTest, UntouchedToothHasWallsAndNoFinishLine) {
  const CrownFigures f = Measure({.cut = false});
  ASSERT_TRUE(f.made);
  EXPECT_EQ(f.complete, 0);
  EXPECT_EQ(f.width_m, 0);
  for (double m : f.wall_m) EXPECT_EQ(m, 0);
  EXPECT_EQ(f.top_m, 0);
}

INSTANTIATE_TEST_SUITE_P(Voxels, CrownTest, testing::Values(100'000, 60'000));

TEST(CrownTargetTest, OnlyCrownsAreMeasuredAsCrowns) {
  scene::CavityTarget target;
  EXPECT_FALSE(IsCrown(target));
  target.landmark = "crown_top";
  EXPECT_TRUE(IsCrown(target));
  target.landmark = "stump";
  target.parts.resize(1);
  EXPECT_FALSE(IsCrown(target));
  target.parts[0].outline = scene::PreparationPart::Outline::kStump;
  EXPECT_TRUE(IsCrown(target));
}

TEST(CrownTargetTest, ReferenceWithoutAFinishLineIsNoCrown) {
  const cutting::Volume tooth = MakeTooth({.cut = false}, 100'000);
  const Tooth untouched = Make({.cut = false}, tooth);
  EXPECT_FALSE(
      MeasureCrown(tooth, untouched.side(), untouched.side(), dvec3(0, 0, 5e-3), 0, 1).in_task);
}

}  // namespace
}  // namespace enamel::scoring
