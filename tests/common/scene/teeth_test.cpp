#include "common/scene/builtin/teeth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/arrangement.h"
#include "common/surface/surface.h"
#include "tests/common/scene/crown_fit.h"

namespace enamel::scene {
namespace {

using cutting::Tissue;

Field FieldOf(const ToothShape& t) {
  return [&t](const dvec3& p) { return ToothField(t, p); };
}

FieldSample At_mm(const ToothShape& t, const dvec3& p_mm) { return ToothField(t, p_mm * 1e-3); }

// The size of a tooth, mm, read from its field on a grid of 0.1 mm.
struct Size {
  double crown_length, root_length, mesiodistal, buccolingual;
};
Size SizeOf(const ToothShape& t) {
  dvec3 lo(99), hi(-99);
  double x0 = 99, x1 = -99, y0 = 99, y1 = -99;
  for (double z = t.lo.z; z < t.hi.z; z += 0.1)
    for (double y = t.lo.y; y < t.hi.y; y += 0.1)
      for (double x = t.lo.x; x < t.hi.x; x += 0.1) {
        if (At_mm(t, {x, y, z}).distance_m > 0) continue;
        lo = glm::min(lo, {x, y, z}), hi = glm::max(hi, {x, y, z});
        if (z < t.cervical_z) continue;
        x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
      }
  return {hi.z - t.cervical_z, t.cervical_z - lo.z, x1 - x0, y1 - y0};
}

double PulpVolume_mm3(const ToothShape& t) {
  double n = 0;
  for (double z = t.lo.z; z < t.hi.z; z += 0.1)
    for (double y = t.lo.y; y < t.hi.y; y += 0.1)
      for (double x = t.lo.x; x < t.hi.x; x += 0.1) {
        FieldSample f = At_mm(t, {x, y, z});
        n += f.distance_m < 0 && f.tissue == Tissue::kPulp;
      }
  return n * 1e-3;
}

// Thickness of enamel over the point (x, y) of the surface: distance to the nearest dentin, mm.
double EnamelThickness_mm(const ToothShape& t, double x, double y) {
  dvec3 top = *SurfaceBelow_m(t, x, y) * 1e3;
  constexpr int kDirections = 400;
  for (double r = 0.1; r < 5; r += 0.02) {
    for (int i = 0; i < kDirections; ++i) {  // a spiral over the sphere
      double z = 1 - 2 * (i + 0.5) / kDirections, a = 2.399963229728653 * i;
      double s = std::sqrt(1 - z * z);
      FieldSample f = At_mm(t, top + r * dvec3(s * std::cos(a), s * std::sin(a), z));
      if (f.distance_m < 0 && f.tissue == Tissue::kDentin) return r;
    }
  }
  return 99;
}

// Cited means (teeth.h). Widths of natural teeth vary by about 0.6 mm (one sigma), lengths by more.
struct Published {
  const ToothShape& (*tooth)();
  Size mean;
  double pulp_mm3;
  size_t cusps;
};
const Published kPublished[] = {
    {LowerFirstMolar, {7.5, 14.0, 11.0, 10.5}, 53, 5},
    {UpperFirstPremolar, {8.5, 14.0, 7.0, 9.0}, 18, 2},
    {UpperCentralIncisor, {10.5, 13.0, 8.5, 7.0}, 12, 0},
};

class ToothTest : public testing::TestWithParam<Published> {
 protected:
  const ToothShape& tooth() const { return GetParam().tooth(); }
};
INSTANTIATE_TEST_SUITE_P(Teeth, ToothTest, testing::ValuesIn(kPublished), [](const auto& tooth) {
  std::string name = tooth.param.tooth().name;
  std::erase(name, '-');
  return name;
});

TEST_P(ToothTest, CrownAndRootAreWithinSixTenthsOfThePublishedMeans) {
  Size s = SizeOf(tooth()), mean = GetParam().mean;
  EXPECT_NEAR(s.crown_length, mean.crown_length, 0.6);
  EXPECT_NEAR(s.root_length, mean.root_length, 0.6);
  EXPECT_NEAR(s.mesiodistal, mean.mesiodistal, 0.6);
  EXPECT_NEAR(s.buccolingual, mean.buccolingual, 0.6);
}

TEST_P(ToothTest, PulpIsWithinAThirdOfThePublishedVolume) {
  EXPECT_NEAR(PulpVolume_mm3(tooth()) / GetParam().pulp_mm3, 1, 0.34);
}

// Highest points within 1.5 mm around, on a grid, not below the middle of the crown.
TEST_P(ToothTest, OcclusalSurfaceHasAsManyCuspsAsTheTooth) {
  const ToothShape& t = tooth();
  constexpr double kStep = 0.1;
  constexpr int kReach = 15;
  int nx = static_cast<int>((t.hi.x - t.lo.x) / kStep),
      ny = static_cast<int>((t.hi.y - t.lo.y) / kStep);
  std::vector<double> height;
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      auto p = SurfaceBelow_m(t, t.lo.x + i * kStep, t.lo.y + j * kStep);
      height.push_back(p ? p->z * 1e3 : -99);
    }
  auto at = [&](int i, int j) { return height[static_cast<size_t>(j * nx + i)]; };
  size_t found = 0;
  for (int j = kReach; j < ny - kReach; ++j)
    for (int i = kReach; i < nx - kReach; ++i) {
      bool top = at(i, j) > 0;
      for (int b = -kReach; top && b <= kReach; ++b)
        for (int a = -kReach; top && a <= kReach; ++a)
          if (a * a + b * b <= kReach * kReach && (a != 0 || b != 0)) {
            top = std::make_pair(at(i + a, j + b), (j + b) * nx + i + a) <
                  std::make_pair(at(i, j), j * nx + i);
          }
      found += top;
    }
  // An incisor has one edge instead.
  EXPECT_EQ(found, std::max<size_t>(GetParam().cusps, 1));
}

TEST_P(ToothTest, EnamelIsThickAtTheCuspsAndEndsAtTheCervicalLine) {
  const ToothShape& t = tooth();
  for (const Cusp& c : t.cusps) {
    double mm = EnamelThickness_mm(t, t.Along(c.x), c.y);
    EXPECT_GT(mm, 1.7) << c.x << " " << c.y;
    EXPECT_LT(mm, 3.0) << c.x << " " << c.y;
  }
  if (t.cusps.empty()) {
    EXPECT_NEAR(EnamelThickness_mm(t, 0, 0), 2.0, 1.2);
  }
  for (double x : {-2.0, 0.0, 2.0})
    for (double y : {-4.0, -2.0, 0.0, 2.0, 4.0}) {
      EXPECT_NE(At_mm(t, {x, y, t.cervical_z - 0.8}).tissue, Tissue::kEnamel);
    }
}

TEST_P(ToothTest, RaysFromOutsideMeetEnamelThenDentinThenPulp) {
  const ToothShape& t = tooth();
  int rays = 0;
  // Level rays at several heights of the crown, toward the pulp chamber's axis.
  double top = std::max(t.pulp.middle.z + t.pulp.half.z, t.cervical_z + t.enamel.mesial_rise + 2.2);
  for (double z = t.cervical_z + t.enamel.mesial_rise + 1; z < top; z += 0.25)
    for (int k = 0; k < 24; ++k) {
      double a = k * 0.2617993877991494;
      dvec3 along(-std::cos(a), -std::sin(a), 0);
      int stage = 0;  // 0 air, 1 enamel, 2 dentin, 3 pulp
      for (double s = 0; s < 8; s += 0.02) {
        dvec3 p = dvec3(0, 0, z) + along * (s - 8);
        FieldSample f = At_mm(t, p);
        int here = f.distance_m > 0              ? 0
                   : f.tissue == Tissue::kEnamel ? 1
                   : f.tissue == Tissue::kDentin ? 2
                                                 : 3;
        ASSERT_GE(here, stage) << "at " << p.x << " " << p.y << " " << z;
        ASSERT_LE(here, stage + 1) << "at " << p.x << " " << p.y << " " << z;
        stage = here;
        if (stage == 3) break;  // behind a horn there is dentin again
      }
      ++rays;
      EXPECT_GE(stage, 2);
    }
  EXPECT_GT(rays, 24);
}

TEST_P(ToothTest, PulpIsUnderAtLeastOneMillimetreOfHardTissueEverywhereInTheCrown) {
  const ToothShape& t = tooth();
  for (double z = t.cervical_z; z < t.hi.z; z += 0.1)
    for (double y = t.lo.y; y < t.hi.y; y += 0.1)
      for (double x = t.lo.x; x < t.hi.x; x += 0.1) {
        FieldSample f = At_mm(t, {x, y, z});
        if (f.tissue != Tissue::kPulp || f.distance_m > 0) continue;
        // Far from the surface the field gives at least half the distance.
        ASSERT_LT(f.distance_m, -0.5e-3) << x << " " << y << " " << z;
      }
}

TEST_P(ToothTest, SurfaceIsClosedAndOfOnePiece) {
  const ToothShape& t = tooth();
  auto mesh = surface::ExtractSurface(
      BuildVolume(GridAround(t.lo * 1e-3, t.hi * 1e-3, 200'000), FieldOf(t), BuildThreads()));
  std::vector<uint32_t> piece(mesh.position_m.size());
  for (uint32_t i = 0; i < piece.size(); ++i) piece[i] = i;
  auto find = [&](uint32_t i) {
    while (piece[i] != i) i = piece[i] = piece[piece[i]];
    return i;
  };
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  for (const auto& tri : mesh.triangles)
    for (size_t k = 0; k < 3; ++k) {
      edges.emplace_back(tri[k], tri[(k + 1) % 3]);
      piece[find(tri[k])] = find(tri[(k + 1) % 3]);
    }
  std::sort(edges.begin(), edges.end());
  for (const auto& [a, b] : edges) {
    ASSERT_TRUE(std::binary_search(edges.begin(), edges.end(), std::make_pair(b, a)));
  }
  size_t pieces = 0;
  for (uint32_t i = 0; i < piece.size(); ++i) pieces += find(i) == i;
  EXPECT_EQ(pieces, 1u);
}

TEST_P(ToothTest, FieldIsATrueDistanceNearTheSurface) {
  const ToothShape& t = tooth();
  // Walking the stated distance along the field's gradient must end on the surface.
  int tested = 0, far_off = 0;
  for (double x = t.lo.x; x < t.hi.x; x += 0.37)
    for (double y = t.lo.y; y < t.hi.y; y += 0.41)
      for (double z = t.lo.z; z < t.hi.z; z += 0.29) {
        dvec3 p = dvec3(x, y, z) * 1e-3;
        double d = ToothField(t, p).distance_m;
        if (std::abs(d) > 0.2e-3) continue;
        dvec3 g;
        for (int i = 0; i < 3; ++i) {
          dvec3 step(0);
          step[i] = 5e-6;
          g[i] = ToothField(t, p + step).distance_m - ToothField(t, p - step).distance_m;
        }
        g /= std::sqrt(Dot(g, g));
        ++tested;
        far_off += std::abs(ToothField(t, p - d * g).distance_m) > 10e-6;
      }
  EXPECT_GT(tested, 400);
  // Fissures, the incisal edge and the furcation have no single gradient.
  EXPECT_LT(far_off, tested / 20);
}

TEST(MolarTest, PulpChamberLiesWhereItWasMeasuredInNaturalMolars) {
  // Deutsch & Musikant 2004, mandibular molars: buccal cusp to chamber roof 6.4 +- 0.9 mm, chamber
  // height 1.6 +- 0.7 mm; two sigma.
  const ToothShape& t = LowerFirstMolar();
  double roof = -99, floor = 99;
  for (double z = -8; z < 4; z += 0.01) {
    if (At_mm(t, {0, 0, z}).tissue != Tissue::kPulp) continue;
    roof = std::max(roof, z), floor = std::min(floor, z);
  }
  double cusp = SurfaceBelow_m(t, t.Along(t.cusps[0].x), t.cusps[0].y)->z * 1e3;
  EXPECT_NEAR(cusp - roof, 6.4, 1.8);
  EXPECT_NEAR(roof - floor, 1.6, 1.4);
}

TEST(ArrangementTest, NeighboursStandClearByTheGapAndAreLabelledApart) {
  ToothShape tooth = LowerFirstMolar();
  tooth.fdi = 36;  // mesial is at +x
  double gap = 0.05, shift = NextToMesially_mm(tooth, tooth, gap);
  Arrangement a;
  a.teeth = {{&tooth, 0, false, {}}, {&tooth, shift, true, {}}};
  int own = 0, other = 0;
  for (double x = 4; x < shift - 4; x += 0.05)
    for (double y = -3; y < 3; y += 0.1)
      for (double z = -3; z < 3; z += 0.1) {
        FieldSample f = ArrangementField(a, dvec3(x, y, z) * 1e-3);
        if (f.distance_m > 0) continue;
        bool left = ToothField(tooth, dvec3(x, y, z) * 1e-3).distance_m < 0;
        bool right = ToothField(tooth, dvec3(x - shift, y, z) * 1e-3).distance_m < 0;
        ASSERT_FALSE(left && right);
        EXPECT_EQ(f.tissue == Tissue::kNeighbour, right);
        own += left, other += right;
      }
  EXPECT_GT(own, 100);
  EXPECT_GT(other, 100);
}

// The means and deviations of teeth.h.
TEST(PrimaryToothTest, APrimaryMolarsCrownIsWithinTwoDeviationsOfThePublishedMeans) {
  const ToothShape& t = PrimarySecondMolar();
  const Size s = SizeOf(t);
  EXPECT_NEAR(s.crown_length, 5.45, 2 * 0.41);
  EXPECT_NEAR(s.mesiodistal, 10.40, 2 * 0.59);
  EXPECT_NEAR(s.buccolingual, 9.24, 2 * 0.54);
  const auto neck = SectionAt_mm(t, t.cervical_z);
  EXPECT_NEAR(neck[0] + neck[1], 7.60, 2 * 0.55);
}

// Straight down from the fossa of the molar, as arrangement.h says.
TEST(ArrangementTest, CariesIsAsDeepAsItsNameSays) {
  const ToothShape& tooth = LowerFirstMolar();
  const dvec3 fossa = FossaBottom_m(tooth) * 1e3;
  const auto first = [&](Tissue tissue) {
    double below = 0;
    while (At_mm(tooth, fossa - dvec3(0, 0, below)).tissue != tissue) below += 0.01;
    return below;
  };
  const double dentin = first(Tissue::kDentin), pulp = first(Tissue::kPulp);
  const auto share = [&](CariesDepth depth) {
    const Lesion lesion = FissureCaries(tooth, depth).back();
    return (fossa.z - lesion.middle.z + lesion.half.z - dentin) / (pulp - dentin);
  };
  EXPECT_GT(share(CariesDepth::kShallow), 0);
  EXPECT_LT(share(CariesDepth::kShallow), 0.25);
  EXPECT_GT(share(CariesDepth::kMedium), 0.25);
  EXPECT_LT(share(CariesDepth::kMedium), 0.5);
  const double over_pulp_mm = (1 - share(CariesDepth::kDeep)) * (pulp - dentin);
  EXPECT_GT(over_pulp_mm, 1.0);
  EXPECT_LT(over_pulp_mm, 1.5);
}

TEST(ArrangementTest, CariesReplacesHardTissueAndLeavesThePulp) {
  const ToothShape& tooth = LowerFirstMolar();
  Arrangement sound{{{&tooth, 0, false, {}}}},
      carious{{{&tooth, 0, false, FissureCaries(tooth, CariesDepth::kMedium)}}};
  int caries = 0;
  for (double x = -3; x < 3; x += 0.1)
    for (double y = -3; y < 3; y += 0.1)
      for (double z = -4; z < 3; z += 0.1) {
        dvec3 p = dvec3(x, y, z) * 1e-3;
        FieldSample a = ArrangementField(sound, p), b = ArrangementField(carious, p);
        EXPECT_EQ(a.distance_m, b.distance_m);
        if (b.tissue == Tissue::kCaries) {
          EXPECT_NE(a.tissue, Tissue::kPulp);
          ++caries;
        } else {
          EXPECT_EQ(a.tissue, b.tissue);
        }
      }
  EXPECT_GT(caries, 2'000);  // over 2 mm^3
}

// A tooth of another number than the built-in one's is shaped like it.
struct GivenCrown {
  int fdi;
  const ToothShape& (*tooth)();
};
class CrownTest : public testing::TestWithParam<GivenCrown> {};
INSTANTIATE_TEST_SUITE_P(
    Fdi, CrownTest,
    testing::Values(GivenCrown{11, UpperCentralIncisor}, GivenCrown{14, UpperFirstPremolar},
                    GivenCrown{16, LowerFirstMolar}, GivenCrown{36, LowerFirstMolar},
                    GivenCrown{46, LowerFirstMolar}, GivenCrown{47, LowerFirstMolar}),
    [](const auto& crown) { return std::to_string(crown.param.fdi); });

TEST_P(CrownTest, ScannedCrownOfTheTypeLiesWithinOneMillimetreAfterRigidAlignment) {
  auto file = std::filesystem::path(ENAMEL_SHARED_DATA) / "crowns" /
              ("fdi_" + std::to_string(GetParam().fdi) + ".obj");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "skipped: no shared data";
  // y is the long axis of these files: the crowns of upper teeth point down, those of lower ones
  // up.
  dvec3 occlusal(0, GetParam().fdi < 30 ? -1 : 1, 0);
  ToothShape t = GetParam().tooth();
  t.fdi = GetParam().fdi;
  auto [lo, hi] = BoundsOf_m(t);
  lo.z = (t.cervical_z - 4) * 1e-3;
  CrownFit fit = FitCrown(ReadScan(file, occlusal), occlusal, FieldOf(t), lo, hi);
  EXPECT_LT(fit.p95_m, 1e-3);
  EXPECT_LT(fit.back_p95_m, 1e-3);
  std::printf("FDI %d: rms %.2f, p95 %.2f, max %.2f mm; back p95 %.2f mm\n", GetParam().fdi,
              fit.rms_m * 1e3, fit.p95_m * 1e3, fit.max_m * 1e3, fit.back_p95_m * 1e3);
}

// A side's half extents differ from the other side's: nothing of that shows where the sides meet, or
// light would find a line one voxel wide down the middle of each face.
TEST(TeethTest, TheFieldHasNoStepWhereTwoSidesMeet) {
  for (const ToothShape* t : BuiltinTeeth()) {
    for (double z = t->cervical_z + 2; z < t->cervical_z + 5; z += 0.25) {
      const auto [mesial, distal, buccal, lingual] = SectionAt_mm(*t, z);
      for (const double depth : {0.1, 0.2, 0.3}) {
        for (const double side : {mesial - depth, depth - distal}) {
          const double x = t->Along(side);
          // The edge of an incisor is so oblique that it falls by 0.012 mm from one to the other.
          EXPECT_NEAR(At_mm(*t, {x, -0.005, z}).distance_m, At_mm(*t, {x, -0.05, z}).distance_m,
                      1.5e-5)
              << t->name << ' ' << side << ' ' << z;
        }
      }
    }
  }
}

}  // namespace
}  // namespace enamel::scene
