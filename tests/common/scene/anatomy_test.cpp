#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/scene/builtin/teeth.h"

// The built-in teeth against the textbooks, in a scene's frame: which side is mesial follows from
// the FDI number alone. Sources: Nelson & Ash, "Wheeler's Dental Anatomy, Physiology and
// Occlusion", 10th ed., Elsevier 2015 (W, with its chapter); Scheid & Weiss, "Woelfel's Dental
// Anatomy", 8th ed., Lippincott 2012 (S).
namespace enamel::scene {
namespace {

double Distance_mm(const ToothShape& t, const dvec3& p_mm) {
  return ToothField(t, p_mm * 1e-3).distance_m * 1e3;
}

// In a patient's own axes (right, to the front, up), which way a tooth's sides face.
struct InTheMouth {
  dvec3 mesial, buccal, occlusal;
};
InTheMouth InTheMouthOf(int tooth) {
  const dvec3 right(1, 0, 0), front(0, 1, 0), up(0, 0, 1);
  const int quadrant = (tooth / 10 - 1) % 4 + 1;
  const dvec3 outward = quadrant == 1 || quadrant == 4 ? right : -right;
  const dvec3 occlusal = quadrant <= 2 ? -up : up;
  // Round the arch: front teeth face the front and have the middle mesially of them.
  if (tooth % 10 <= 2) return {-outward, front, occlusal};
  return {front, outward, occlusal};
}

TEST(ToothNumberTest, MesialIsWhereARightHandedFrameHasItInThePatientsMouth) {
  int teeth = 0;
  for (int tooth = 0; tooth < 100; ++tooth) {
    if (!IsToothNumber(tooth)) {
      EXPECT_EQ(MesialX(tooth), 1) << tooth;
      continue;
    }
    ++teeth;
    const InTheMouth sides = InTheMouthOf(tooth);
    EXPECT_EQ(Dot(glm::cross(sides.buccal, sides.occlusal), sides.mesial), MesialX(tooth)) << tooth;
  }
  EXPECT_EQ(teeth, 32 + 20);
}

TEST(ToothNumberTest, FrontTeethAreIncisorsAndCanines) {
  EXPECT_TRUE(IsAnterior(11) && IsAnterior(43) && IsAnterior(73));
  EXPECT_FALSE(IsAnterior(14) || IsAnterior(46) || IsAnterior(54) || IsAnterior(0));
}

TEST(AnatomyTest, ALeftToothIsTheMirrorImageOfTheRightOne) {
  for (const ToothShape* tooth : BuiltinTeeth()) {
    ToothShape other = *tooth;
    other.fdi = tooth->fdi + (tooth->fdi / 10 % 2 == 1 ? 10 : -10);
    ASSERT_EQ(MesialX(other.fdi), -MesialX(tooth->fdi));
    const auto [lo, hi] = BoundsOf_m(*tooth);
    int differ = 0;
    for (double x = lo.x; x < hi.x; x += 0.41e-3)
      for (double y = lo.y; y < hi.y; y += 0.43e-3)
        for (double z = lo.z; z < hi.z; z += 0.47e-3) {
          const FieldSample a = ToothField(*tooth, {x, y, z}), b = ToothField(other, {-x, y, z});
          ASSERT_EQ(a.distance_m, b.distance_m);
          ASSERT_EQ(a.tissue, b.tissue);
          differ += ToothField(other, {x, y, z}).distance_m != a.distance_m;
        }
    EXPECT_GT(differ, 1000) << tooth->name << " has no left and right";
    EXPECT_EQ(FossaBottom_m(*tooth).x, -FossaBottom_m(other).x);
  }
}

// A place on the tooth, mm: how far mesially of its middle, buccally and occlusally.
struct Place {
  double mesially = 0, buccally = 0, height = 0;
};

// The tips of the cusps: highest points within 1.6 mm around, above the crown's middle, from mesial
// to distal.
std::vector<Place> CuspsOf(const ToothShape& t) {
  constexpr double kStep = 0.2;
  constexpr int kReach = 8, kHalf = 32;
  auto height = [&](int i, int j) {
    const auto p = SurfaceBelow_m(t, i * kStep, j * kStep);
    return p ? p->z * 1e3 : -99;
  };
  std::vector<double> grid(static_cast<size_t>((2 * kHalf + 1) * (2 * kHalf + 1)));
  auto at = [&](int i, int j) -> double& {
    return grid[static_cast<size_t>((j + kHalf) * (2 * kHalf + 1) + i + kHalf)];
  };
  for (int j = -kHalf; j <= kHalf; ++j)
    for (int i = -kHalf; i <= kHalf; ++i) at(i, j) = height(i, j);
  std::vector<Place> out;
  for (int j = -kHalf + kReach; j <= kHalf - kReach; ++j)
    for (int i = -kHalf + kReach; i <= kHalf - kReach; ++i) {
      bool top = at(i, j) > 0;
      for (int b = -kReach; top && b <= kReach; ++b)
        for (int a = -kReach; top && a <= kReach; ++a) {
          if (a * a + b * b > kReach * kReach || (a == 0 && b == 0)) continue;
          top = at(i + a, j + b) < at(i, j) || (at(i + a, j + b) == at(i, j) && (b > 0 || a > 0));
        }
      if (top) out.push_back({MesialX(t.fdi) * i * kStep, j * kStep, at(i, j)});
    }
  std::ranges::sort(out, [](const Place& a, const Place& b) { return a.mesially > b.mesially; });
  return out;
}
std::vector<Place> Buccal(std::vector<Place> cusps) {
  std::erase_if(cusps, [](const Place& c) { return c.buccally < 0; });
  return cusps;
}
std::vector<Place> Lingual(std::vector<Place> cusps) {
  std::erase_if(cusps, [](const Place& c) { return c.buccally >= 0; });
  return cusps;
}

// From a middle outwards, where the tooth ends.
template <typename At>
double Reach_mm(const ToothShape& t, const At& at) {
  double out = 0;
  while (out < 9 && Distance_mm(t, at(out)) < 0) out += 0.2;
  double in = out - 0.2;
  for (int i = 0; i < 6; ++i) {
    const double middle = 0.5 * (in + out);
    (Distance_mm(t, at(middle)) < 0 ? in : out) = middle;
  }
  return std::max(0.0, in);
}
// How far the crown reaches at a height, mm, from its middle: to mesial or distal (`mesially` 1 or
// -1) at a place along y, to buccal or lingual at a place along x.
double ReachAlong_mm(const ToothShape& t, int mesially, double y, double z) {
  return Reach_mm(t, [&](double x) { return dvec3(mesially * MesialX(t.fdi) * x, y, z); });
}
double ReachAcross_mm(const ToothShape& t, int buccally, double mesially, double z) {
  return Reach_mm(t, [&](double y) { return dvec3(MesialX(t.fdi) * mesially, buccally * y, z); });
}
// Along a face from mesial to distal, the places of its grooves: where it is hollow by `depth_mm`
// over 1.6 mm, and nowhere more beside.
std::vector<double> GroovesOn(const ToothShape& t, int buccally, double z, double depth_mm) {
  constexpr double kStep = 0.1, kFrom = 4.4;
  constexpr size_t kBeside = 8;
  std::vector<double> reach, hollow;
  for (double x = kFrom; x >= -kFrom; x -= kStep)
    reach.push_back(ReachAcross_mm(t, buccally, x, z));
  for (size_t i = kBeside; i + kBeside < reach.size(); ++i) {
    hollow.push_back(0.5 * (reach[i - kBeside] + reach[i + kBeside]) - reach[i]);
  }
  std::vector<double> out;
  for (size_t i = 1; i + 1 < hollow.size(); ++i) {
    if (hollow[i] < depth_mm || hollow[i] <= hollow[i - 1] || hollow[i] < hollow[i + 1]) continue;
    out.push_back(kFrom - static_cast<double>(i + kBeside) * kStep);
  }
  return out;
}

// Where enamel begins on a face, going up, mm over the same in the middle of the buccal face.
double CervicalRise_mm(const ToothShape& t, int mesially) {
  auto begins = [&](auto surface) {
    for (double z = t.cervical_z - 1; z < t.hi.z; z += 0.01) {
      if (ToothField(t, surface(z) * 1e-3).tissue == cutting::Tissue::kEnamel) return z;
    }
    return t.hi.z;
  };
  const double on_face = begins([&](double z) {
    const double x = ReachAlong_mm(t, mesially, 0, z) - 0.05;
    return dvec3(mesially * MesialX(t.fdi) * x, 0, z);
  });
  return on_face - begins([&](double z) { return dvec3(0, ReachAcross_mm(t, 1, 0, z) - 0.05, z); });
}

// Neighbours are set by their sections: what bulged beyond these would close the gap between them.
TEST(AnatomyTest, ACrownIsNowhereWiderThanItsSections) {
  for (const ToothShape* t : BuiltinTeeth()) {
    for (double z = t->cervical_z + 0.5; z < t->hi.z - 1; z += 0.5) {
      const auto [mesial, distal, buccal, lingual] = SectionAt_mm(*t, z);
      for (double aside = -2; aside <= 2; aside += 0.25) {
        EXPECT_LE(ReachAlong_mm(*t, 1, aside, z), mesial + 0.005) << t->name << " at " << z;
        EXPECT_LE(ReachAlong_mm(*t, -1, aside, z), distal + 0.005) << t->name << " at " << z;
        EXPECT_LE(ReachAcross_mm(*t, 1, aside, z), buccal + 0.005) << t->name << " at " << z;
        EXPECT_LE(ReachAcross_mm(*t, -1, aside, z), lingual + 0.005) << t->name << " at " << z;
      }
    }
  }
}

// W, tables of measurements: width at the cervix from mesial to distal and from buccal to lingual,
// and the curvature of the cervical line on the mesial and the distal face.
TEST(AnatomyTest, TheCervixIsAsWideAndItsLineAsCurvedAsTabled) {
  const struct {
    const ToothShape& (*tooth)();
    double mesiodistal, buccolingual, mesial_rise, distal_rise;
  } tabled[] = {{LowerFirstMolar, 9, 9, 1, 0},
                {UpperFirstPremolar, 5, 8, 1, 0},
                {UpperCentralIncisor, 7, 6, 3.5, 2.5}};
  for (const auto& row : tabled) {
    const ToothShape& t = row.tooth();
    const double z = t.cervical_z;
    EXPECT_NEAR(ReachAlong_mm(t, 1, 0, z) + ReachAlong_mm(t, -1, 0, z), row.mesiodistal, 0.6)
        << t.name;
    EXPECT_NEAR(ReachAcross_mm(t, 1, 0, z) + ReachAcross_mm(t, -1, 0, z), row.buccolingual, 0.6)
        << t.name;
    EXPECT_NEAR(CervicalRise_mm(t, 1), row.mesial_rise, 0.3) << t.name;
    EXPECT_NEAR(CervicalRise_mm(t, -1), row.distal_rise, 0.3) << t.name;
  }
}

// W 12, S: five cusps. By height: mesiolingual, distolingual, mesiobuccal, distobuccal, distal.
TEST(Tooth46Test, HasFiveCuspsOfWhichTheMesiolingualIsTheHighestAndTheDistalTheLowest) {
  const std::vector<Place> all = CuspsOf(LowerFirstMolar());
  ASSERT_EQ(all.size(), 5u);
  const auto buccal = Buccal(all), lingual = Lingual(all);
  ASSERT_EQ(buccal.size(), 3u);
  ASSERT_EQ(lingual.size(), 2u);
  const Place &mesiobuccal = buccal[0], &distobuccal = buccal[1], &distal = buccal[2];
  EXPECT_GT(lingual[0].height, lingual[1].height);
  EXPECT_GT(lingual[1].height, mesiobuccal.height);
  EXPECT_GT(mesiobuccal.height, distobuccal.height);
  EXPECT_GT(distobuccal.height, distal.height);
  // The distal cusp is at the distobuccal corner, further in than the other two.
  EXPECT_LT(distal.buccally, distobuccal.buccally - 0.5);
  EXPECT_LT(distal.mesially, lingual[1].mesially - 0.5);
}

// Right teeth of the lower jaw, seen from above with buccal up: distal is to the right.
TEST(Tooth46Test, HasItsDistalCuspAtPlusXAndA36AtMinusX) {
  const ToothShape& t46 = LowerFirstMolar();
  ASSERT_EQ(t46.fdi, 46);
  auto t36 = t46;
  t36.fdi = 36;
  auto distal_x = [](const ToothShape& t) {
    return MesialX(t.fdi) * Buccal(CuspsOf(t)).back().mesially;
  };
  EXPECT_GT(distal_x(t46), 3);
  EXPECT_LT(distal_x(t36), -3);
}

// W 12: the mesiobuccal groove between the mesiobuccal and the distobuccal cusp, the distobuccal
// groove, which is the longer, between the distobuccal and the distal cusp, and one lingual groove.
TEST(Tooth46Test, HasTwoBuccalGroovesAndOneLingualBetweenItsCusps) {
  const ToothShape& t = LowerFirstMolar();
  const auto buccal = Buccal(CuspsOf(t)), lingual = Lingual(CuspsOf(t));
  const auto high = GroovesOn(t, 1, 1.2, 0.05);
  ASSERT_EQ(high.size(), 2u);
  EXPECT_LT(high[0], buccal[0].mesially);
  EXPECT_GT(high[0], buccal[1].mesially);
  EXPECT_LT(high[1], buccal[1].mesially);
  EXPECT_GT(high[1], buccal[2].mesially);
  const auto inner = GroovesOn(t, -1, 1.2, 0.05);
  ASSERT_EQ(inner.size(), 1u);
  EXPECT_LT(inner[0], lingual[0].mesially);
  EXPECT_GT(inner[0], lingual[1].mesially);
  const auto low = GroovesOn(t, 1, -1.5, 0.02);
  ASSERT_EQ(low.size(), 1u) << "the mesiobuccal one has ended";
  EXPECT_NEAR(low[0], high[1], 0.5);
}

// S: the fissures make a Y, as the mesiolingual cusp meets the distobuccal one in the middle and
// keeps the mesiobuccal from the distolingual.
TEST(Tooth46Test, HasTheFissurePatternY5) {
  const ToothShape& t = LowerFirstMolar();
  const auto buccal = Buccal(CuspsOf(t)), lingual = Lingual(CuspsOf(t));
  // The highest that the valley between two cusps lets one go from tip to tip.
  auto pass = [&](const Place& a, const Place& b) {
    double lowest = 9;
    for (double s = 0; s <= 1; s += 0.01) {
      const double x = a.mesially + s * (b.mesially - a.mesially);
      const double y = a.buccally + s * (b.buccally - a.buccally);
      lowest = std::min(lowest, OcclusalHeight_mm(t, MesialX(t.fdi) * x, y));
    }
    return lowest;
  };
  EXPECT_GT(pass(lingual[0], buccal[1]), pass(buccal[0], lingual[1]));
}

// W 12: the crown is wider from mesial to distal than across; it converges to lingual and to
// distal. The mesial marginal ridge is higher than the distal.
TEST(Tooth46Test, CrownConvergesToLingualAndToDistal) {
  const ToothShape& t = LowerFirstMolar();
  constexpr double kZ = -0.5;
  auto length = [&](double y) { return ReachAlong_mm(t, 1, y, kZ) + ReachAlong_mm(t, -1, y, kZ); };
  auto width = [&](double mesially) {
    return ReachAcross_mm(t, 1, mesially, kZ) + ReachAcross_mm(t, -1, mesially, kZ);
  };
  EXPECT_GT(length(0), width(0) + 0.3);
  EXPECT_GT(length(3), length(-3) + 0.5);
  EXPECT_GT(width(3), width(-3) + 0.3);
  const double x = MesialX(t.fdi) * 4.4;
  EXPECT_GT(OcclusalHeight_mm(t, x, 0), OcclusalHeight_mm(t, -x, 0) + 0.05);
}

struct Section {
  std::vector<Place> middles;
  std::vector<double> widths;  // from buccal to lingual
};
// The roots at a height: pieces of the section along x (or along y), mesial or buccal first.
Section RootsAt(const ToothShape& t, bool along_x, double z) {
  Section out;
  double from = 99;
  for (double s = 6.5; s >= -6.5; s -= 0.02) {
    const dvec3 p = along_x ? dvec3(MesialX(t.fdi) * s, 0, z) : dvec3(0, s, z);
    const bool solid = Distance_mm(t, p) < 0;
    if (solid && from > 90) from = s;
    if (solid || from > 90) continue;
    const double middle = 0.5 * (from + s);
    out.middles.push_back(along_x ? Place{middle, 0, z} : Place{0, middle, z});
    out.widths.push_back(ReachAcross_mm(t, 1, middle, z) + ReachAcross_mm(t, -1, middle, z));
    from = 99;
  }
  return out;
}

// W 12: two roots. The mesial one is the wider from buccal to lingual, bows to mesial and ends
// distally of its bow; the distal one is straight. They part about 3 mm below the cervical line.
TEST(Tooth46Test, HasAMesialAndADistalRoot) {
  const ToothShape& t = LowerFirstMolar();
  EXPECT_EQ(RootsAt(t, true, t.cervical_z - 1.5).middles.size(), 1u) << "the trunk";
  const Section high = RootsAt(t, true, t.cervical_z - 6),
                low = RootsAt(t, true, t.cervical_z - 12);
  ASSERT_EQ(high.middles.size(), 2u);
  ASSERT_EQ(low.middles.size(), 2u);
  EXPECT_GT(high.middles[0].mesially, 1);
  EXPECT_LT(high.middles[1].mesially, -1);
  EXPECT_GT(high.widths[0], high.widths[1]);
  EXPECT_LT(low.middles[0].mesially, high.middles[0].mesially - 0.1);
  EXPECT_LT(low.middles[1].mesially, high.middles[1].mesially);
}

// W 9, S: the buccal cusp is about 1 mm the higher, and its tip is distal of the middle, the
// lingual cusp's mesial.
TEST(Tooth14Test, HasABuccalCuspDistallyAndAShorterLingualOneMesially) {
  const ToothShape& t = UpperFirstPremolar();
  ASSERT_EQ(t.fdi, 14);
  const auto all = CuspsOf(t);
  ASSERT_EQ(all.size(), 2u);
  const Place buccal = Buccal(all).at(0), lingual = Lingual(all).at(0);
  EXPECT_NEAR(buccal.height - lingual.height, 1, 0.4);
  EXPECT_LT(buccal.mesially, 0);
  EXPECT_GT(lingual.mesially, buccal.mesially + 0.2);
}

// W 9: a depression on the mesial face, from under the contact onto the root, and none on the
// distal; a groove crosses the mesial marginal ridge.
TEST(Tooth14Test, HasAMesialDepressionAndAGrooveAcrossItsMesialMarginalRidge) {
  const ToothShape& t = UpperFirstPremolar();
  for (double z : {t.cervical_z + 0.5, t.cervical_z - 1.0}) {
    auto hollow = [&](int mesially) {
      const double beside =
          0.5 * (ReachAlong_mm(t, mesially, 1.6, z) + ReachAlong_mm(t, mesially, -1.6, z));
      return beside - ReachAlong_mm(t, mesially, 0, z);
    };
    EXPECT_GT(hollow(1), 0.1) << z;
    EXPECT_LT(hollow(-1), 0.05) << z;
  }
  auto notch = [&](int mesially) {
    const double x = MesialX(t.fdi) * mesially * 2.6;
    return std::min(OcclusalHeight_mm(t, x, 0.8), OcclusalHeight_mm(t, x, -0.8)) -
           OcclusalHeight_mm(t, x, 0);
  };
  EXPECT_GT(notch(1), 0.15);
  EXPECT_LT(notch(-1), 0.05);
}

// W 9: in most two roots, a buccal and a lingual one, which part in the middle of the root's
// length.
TEST(Tooth14Test, HasABuccalAndALingualRoot) {
  const ToothShape& t = UpperFirstPremolar();
  EXPECT_EQ(RootsAt(t, false, t.cervical_z - 3).middles.size(), 1u);
  const Section roots = RootsAt(t, false, t.cervical_z - 9);
  ASSERT_EQ(roots.middles.size(), 2u);
  EXPECT_GT(roots.middles[0].buccally, 1);
  EXPECT_LT(roots.middles[1].buccally, -1);
}

// W 6: the mesioincisal angle is the sharper one; the mesial contact is in the incisal third, the
// distal one further from the edge. One root. The lingual face is hollow, the labial one is not.
TEST(Tooth11Test, HasASharpMesioincisalAngleARoundedDistoincisalOneAndALingualFossa) {
  const ToothShape& t = UpperCentralIncisor();
  ASSERT_EQ(t.fdi, 11);
  const double edge = CuspsOf(t).at(0).height;
  auto contact = [&](int mesially) {
    double best = 0, at = 0;
    for (double z = t.cervical_z; z < edge; z += 0.05) {
      if (const double x = ReachAlong_mm(t, mesially, 0.3, z); x > best + 1e-9) best = x, at = z;
    }
    return std::pair(at, best);
  };
  const auto [mesial_z, mesial_x] = contact(1);
  const auto [distal_z, distal_x] = contact(-1);
  EXPECT_GT(mesial_z, distal_z + 0.3);
  EXPECT_GT(mesial_z, edge - 10.5 / 3);
  // How much of the contact's reach is lost half a millimetre below the edge.
  const double z = edge - 0.5;
  EXPECT_LT(mesial_x - ReachAlong_mm(t, 1, 0.1, z), distal_x - ReachAlong_mm(t, -1, 0.1, z) - 0.1);
  EXPECT_EQ(RootsAt(t, true, t.cervical_z - 9).middles.size(), 1u);
  EXPECT_EQ(RootsAt(t, false, t.cervical_z - 9).middles.size(), 1u);
  auto hollow = [&](int buccally) {
    constexpr double kZ = 1.5;
    return 0.5 * (ReachAcross_mm(t, buccally, 2.8, kZ) + ReachAcross_mm(t, buccally, -2.8, kZ)) -
           ReachAcross_mm(t, buccally, 0, kZ);
  };
  EXPECT_GT(hollow(-1), 0);
  EXPECT_LT(hollow(1), 0);
}

}  // namespace
}  // namespace enamel::scene
