#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>

#include "tests/common/scoring/synthetic_cavity.h"

// Faults made by formula, on and off the grid, at three voxel sizes: each metric finds its own
// within a quarter of a voxel (volumes: area times that) or half a degree, and what it is not about
// leaves it alone. Volumes are filled from closed forms here; no cutter made them.
namespace enamel::scoring {
namespace {

using cutting::Tissue;
using cutting::Volume;

constexpr double kMm = 1e-3;
constexpr double kHalfX_mm = 1.5, kHalfY_mm = 1.2, kDepth_mm = 2;  // BlockExercise's target

// What is taken out of the block, as a distance in mm: negative inside.
using Hollow = std::function<double(const dvec3& p_mm)>;

struct Grid {
  int32_t voxel_nm;
  double shift_mm = 0;     // of the whole grid
  double turn_deg = 0;     // of what is cut, about +z
  bool only_full = false;  // by ./check --full only: long
};

double BoxDistance_mm(const dvec3& p, const dvec3& lo, const dvec3& hi) {
  dvec3 d = glm::max(lo - p, p - hi);
  dvec3 out = glm::max(d, dvec3(0));
  return std::sqrt(Dot(out, out)) + std::min(0.0, std::max(d.x, std::max(d.y, d.z)));
}

// A block of 7 x 6 x 4 mm, its top at z = 0; a neighbour of 1 mm beyond a gap of 0.2 mm at its
// mesial side; caries in a ball under the floor of the cavity.
constexpr double kCariesRadius_mm = 0.6;
const dvec3 kCaries_mm(0.2, -0.1, -1.9);
const dvec3 kBlockLo_mm(-3.5, -3, -4), kBlockHi_mm(3.5, 3, 0);
const dvec3 kNextLo_mm(3.7, -3, -4), kNextHi_mm(4.7, 3, 0);

Tissue TissueAt(const dvec3& p) {
  if (p.x > 3.6) return Tissue::kNeighbour;
  dvec3 d = p - kCaries_mm;
  if (Dot(d, d) < kCariesRadius_mm * kCariesRadius_mm) return Tissue::kCaries;
  return p.z > -1.2 ? Tissue::kEnamel : p.z > -3.2 ? Tissue::kDentin : Tissue::kPulp;
}

Volume Filled(const Grid& grid, const Hollow& hollow) {
  cutting::GridSpec spec;
  spec.voxel_nm = grid.voxel_nm;
  auto nm = [&](double mm) {
    return static_cast<int64_t>(std::llround((mm + grid.shift_mm) * 1e6));
  };
  spec.origin_nm = {nm(-4.2), nm(-3.7), nm(-4.7)};
  double side = cutting::kBrickSide * grid.voxel_nm * 1e-6;
  auto bricks = [&](double mm) { return static_cast<int>(mm / side) + 1; };
  spec.bricks = ivec3(bricks(9.6), bricks(7.4), bricks(5.4));
  Volume volume(spec);
  const double turn = grid.turn_deg * 3.14159265358979 / 180;
  const double c = std::cos(turn), s = std::sin(turn);
  for (int b = 0; b < spec.brick_count(); ++b) {
    ivec3 first = ivec3(b % spec.bricks.x, b / spec.bricks.x % spec.bricks.y,
                        b / (spec.bricks.x * spec.bricks.y)) *
                  cutting::kBrickSide;
    std::array<int16_t, cutting::kBrickVoxels> phi;
    std::vector<uint8_t> labels(cutting::kBrickVoxels);
    bool solid = false;
    for (size_t i = 0; i < phi.size(); ++i) {
      const auto n = static_cast<int>(i);
      dvec3 p =
          (spec.origin_m() + dvec3(first + ivec3(n & 7, n >> 3 & 7, n >> 6)) * spec.voxel_m()) /
          kMm;
      double outside = std::min(BoxDistance_mm(p, kBlockLo_mm, kBlockHi_mm),
                                BoxDistance_mm(p, kNextLo_mm, kNextHi_mm));
      double units = std::max(outside, -hollow(dvec3(c * p.x + s * p.y, c * p.y - s * p.x, p.z))) *
                     kMm / spec.voxel_m() * cutting::kPhiPerVoxel;
      phi[i] = static_cast<int16_t>(std::lround(std::clamp(units, -32767.0, 32767.0)));
      labels[i] = static_cast<uint8_t>(TissueAt(p));
      solid = solid || phi[i] < cutting::kPhiLimit;
    }
    if (solid) volume.SetBrick(b, phi, labels, Tissue::kEnamel);
  }
  return volume;
}

double Nothing(const dvec3&) { return 1e3; }
double Everything(const dvec3&) { return -1e3; }

// The cavity between five planes; `mesial` and `floor` say how far theirs are moved outwards at a
// point, mm. A plane z = f(x, y) of small slope is met to second order.
struct Planes {
  std::function<double(const dvec3&)> mesial = [](const dvec3&) { return 0.0; };
  std::function<double(const dvec3&)> floor = [](const dvec3&) { return 0.0; };
  double mesial_slope = 0;  // dx/dz, by which distances to it shrink
  double Distance(const dvec3& p) const {
    double mesial_d = (p.x - (kHalfX_mm + mesial(p))) / std::sqrt(1 + mesial_slope * mesial_slope);
    double sides =
        std::max(std::max(mesial_d, -kHalfX_mm - p.x), std::max(p.y - kHalfY_mm, -kHalfY_mm - p.y));
    return std::max(sides, -kDepth_mm - floor(p) - p.z);
  }
};

struct Filling {
  Volume volume;
  surface::Mesh mesh;
  ProcessRecorder process = StraightRecording(1000, 1, 1);
  explicit Filling(Volume v) : volume(std::move(v)), mesh(surface::ExtractSurface(volume)) {}
};

class KnownFaults : public testing::TestWithParam<Grid> {
 protected:
  // A grid that is only for ./check --full is filled coarsely where it is skipped.
  KnownFaults()
      : initial_(Filled(Used(), Nothing)),
        reference_(Filled(Used(), [](const dvec3& p) { return Planes{}.Distance(p); })) {}
  void SetUp() override {
    if (!Runs()) GTEST_SKIP() << "takes minutes: ./check --full";
  }
  static bool Runs() { return !GetParam().only_full || std::getenv("ENAMEL_FULL") != nullptr; }
  static Grid Used() { return Runs() ? GetParam() : Grid{400'000}; }

  Filling Cut(const Hollow& hollow) const { return Filling(Filled(GetParam(), hollow)); }
  Filling Cut(const Planes& planes) const {
    return Cut([&](const dvec3& p) { return planes.Distance(p); });
  }
  // The reference's cavity and something more.
  Filling CutAlso(const Hollow& more) const {
    return Cut([&](const dvec3& p) { return std::min(Planes{}.Distance(p), more(p)); });
  }
  MetricSet Measure(const Filling& attempt) const {
    auto data = [&](const Filling& f) {
      return AttemptData{&initial_, &f.volume, &f.mesh, &f.process};
    };
    auto metrics = ComputeMetrics(BlockScene(), BlockExercise(), data(attempt), data(reference_));
    EXPECT_TRUE(metrics.ok()) << metrics.status().message();
    return metrics.ok() ? *metrics : MetricSet{};
  }
  double tolerance_mm() const { return GetParam().voxel_nm * 1e-6 / 4; }

  const Volume initial_;
  const Filling reference_;
};

Planes Leaning(double degrees) {
  Planes out;
  out.mesial_slope = std::tan(degrees * 3.14159265358979 / 180);
  // About the wall's middle; + opens to the top.
  out.mesial = [slope = out.mesial_slope](const dvec3& p) { return slope * (p.z + kDepth_mm / 2); };
  return out;
}

TEST_P(KnownFaults, NothingIsFoundInTheReferenceItself) {
  MetricSet m = Measure(reference_);
  for (const char* name :
       {"deviation_rms_mm", "deviation_p95_mm", "deepest_over_mm", "most_left_mm", "wall_mesial_mm",
        "floor_mm", "wall_tilt_deg", "tilt_floor_deg", "missed_mm3", "overcut_mm3",
        "outside_removed_mm3", "damage_percent", "neighbour_removed_mm3", "caries_left_mm3",
        "sound_removed_mm3", "outline_over_mm", "outline_short_mm"}) {
    EXPECT_NEAR(ValueOf(m, name), 0, 1e-9) << name;
  }
  for (const char* name : {"task_done_percent", "overlap_percent", "within_100um_percent"}) {
    EXPECT_NEAR(ValueOf(m, name), 100, 1e-9) << name;
  }
  EXPECT_LT(ValueOf(m, "undercut_deg"), 0.5);
}

TEST_P(KnownFaults, ALeaningWallIsFoundWithinHalfADegree) {
  for (double degrees : {1.0, 5.0, 10.0, 20.0, -1.0, -5.0, -10.0, -20.0}) {
    MetricSet m = Measure(Cut(Leaning(degrees)));
    EXPECT_NEAR(ValueOf(m, "tilt_mesial_deg"), degrees, 0.5) << degrees;
    EXPECT_NEAR(ValueOf(m, "wall_tilt_deg"), std::fabs(degrees), 0.5) << degrees;
    EXPECT_NEAR(ValueOf(m, "undercut_deg"), std::max(0.0, -degrees), 0.5) << degrees;
    EXPECT_NEAR(ValueOf(m, "tilt_distal_deg"), 0, 0.5) << degrees;
    EXPECT_NEAR(ValueOf(m, "tilt_floor_deg"), 0, 0.5) << degrees;
  }
}

TEST_P(KnownFaults, ATiltedFloorIsFoundWithinHalfADegree) {
  for (double degrees : {1.0, 5.0, 15.0}) {
    Planes planes;
    const double slope = std::tan(degrees * 3.14159265358979 / 180);
    planes.floor = [=](const dvec3& p) { return slope * p.x; };
    MetricSet m = Measure(Cut(planes));
    EXPECT_NEAR(ValueOf(m, "tilt_floor_deg"), degrees, 0.5) << degrees;
    EXPECT_NEAR(ValueOf(m, "wall_tilt_deg"), 0, 0.5) << degrees;
  }
}

TEST_P(KnownFaults, AWavyWallIsFoundWithinAQuarterVoxel) {
  for (double size_mm : {0.05, 0.1, 0.2}) {
    Planes planes;
    // Three waves along the wall, so that neither offset nor tilt hides it.
    planes.mesial = [=](const dvec3& p) {
      return size_mm * std::sin(3 * 3.14159265358979 * p.y / kHalfY_mm);
    };
    MetricSet m = Measure(Cut(planes));
    EXPECT_NEAR(ValueOf(m, "wall_waviness_mm"), size_mm / std::sqrt(2.0), tolerance_mm())
        << size_mm;
    EXPECT_LT(ValueOf(m, "floor_waviness_mm"), tolerance_mm());
  }
}

TEST_P(KnownFaults, AnotherHoleIsCutElsewhereAndNotBesideTheWalls) {
  const dvec3 lo(-3.2, -2.8, -1), hi(-2.4, 2.8, 9);
  MetricSet m = Measure(CutAlso([&](const dvec3& p) { return BoxDistance_mm(p, lo, hi); }));
  const double area = 2 * (0.8 + 5.6) * 1 + 0.8 * 5.6;
  EXPECT_NEAR(ValueOf(m, "outside_removed_mm3"), 0.8 * 5.6, area * tolerance_mm());
  EXPECT_NEAR(ValueOf(m, "sound_removed_mm3"), 0.8 * 5.6, area * tolerance_mm());
  EXPECT_NEAR(ValueOf(m, "overcut_mm3"), 0, area * tolerance_mm());
  EXPECT_NEAR(ValueOf(m, "task_done_percent"), 100, 0.01);
  EXPECT_NEAR(ValueOf(m, "deepest_over_mm"), 1, 0.2);
  EXPECT_NEAR(ValueOf(m, "deviation_rms_mm"), 0, 1e-6) << "the reference's cut is as it was";
}

TEST_P(KnownFaults, ShavingTheWholeBlockCostsAndImprovesNoStatistic) {
  const double shaved_mm = 0.05;
  MetricSet m = Measure(CutAlso([&](const dvec3& p) { return -shaved_mm - p.z; }));
  // All of the top but the opening and its leeway of 0.2 mm.
  const double leeway = 0.2, near = (3 + 2 * leeway) * (2.4 + 2 * leeway), top = 7 * 6 + 1 * 6;
  EXPECT_NEAR(ValueOf(m, "outside_removed_mm3") + ValueOf(m, "neighbour_removed_mm3"),
              (top - near) * shaved_mm, top * tolerance_mm());
  // Only the rim of the walls is gone with it.
  EXPECT_LT(ValueOf(m, "deviation_rms_mm"), 0.02);
  EXPECT_GE(ValueOf(m, "deviation_rms_mm"), 0);
}

TEST_P(KnownFaults, WhatIsTakenFromTheNeighbourIsItsVolumeAndDepth) {
  const dvec3 lo(3.0, -0.5, -1), hi(4.0, 0.5, 9);
  MetricSet m = Measure(CutAlso([&](const dvec3& p) { return BoxDistance_mm(p, lo, hi); }));
  const double area = 2 * 1 * (0.3 + 1) + 0.3;
  EXPECT_NEAR(ValueOf(m, "neighbour_removed_mm3"), 0.3 * 1 * 1, area * tolerance_mm());
  // Of a turned box the corner goes deepest.
  const double turn = std::fabs(GetParam().turn_deg) * 3.14159265358979 / 180;
  const double depth = hi.x * std::cos(turn) + hi.y * std::sin(turn) - kNextLo_mm.x;
  EXPECT_NEAR(ValueOf(m, "neighbour_depth_mm"), depth, 2 * tolerance_mm());
  EXPECT_EQ(ValueOf(Measure(reference_), "neighbour_removed_mm3"), 0);
}

TEST_P(KnownFaults, CariesThatWasLeftIsCariesAndWhatWasTakenIsNotSoundTissue) {
  // Half a millimetre short of the floor: the ball's cap between is left.
  Planes shallow;
  shallow.floor = [](const dvec3&) { return -0.5; };
  MetricSet m = Measure(Cut(shallow));
  auto cap = [](double height) {  // of the ball above a plane
    return 3.14159265358979 * height * height * (kCariesRadius_mm - height / 3);
  };
  const double above_floor = kCaries_mm.z + kCariesRadius_mm + kDepth_mm;
  const double task = cap(above_floor), left = task - cap(above_floor - 0.5);
  // The label's boundary is whole voxels: half a voxel off at the worst, on average none.
  EXPECT_NEAR(ValueOf(m, "caries_left_mm3"), left, 1.1 * tolerance_mm());
  EXPECT_NEAR(ValueOf(m, "caries_left_percent"), 100 * left / task, 6);
  EXPECT_NEAR(ValueOf(m, "sound_removed_mm3"), 0, 1e-6);
  EXPECT_NEAR(ValueOf(m, "missed_mm3"), 0.5 * 3 * 2.4, (3 * 2.4 + 2 * 5.4) * tolerance_mm());
}

TEST_P(KnownFaults, AnUntouchedToothHasDoneNothingAndADestroyedOneEverythingElse) {
  MetricSet none = Measure(Cut(Nothing));
  EXPECT_EQ(ValueOf(none, "task_done_percent"), 0);
  EXPECT_EQ(ValueOf(none, "damage_percent"), 0);
  EXPECT_GT(ValueOf(none, "deviation_rms_mm"), 0.5);
  for (const MissingMetric& m : none.missing) EXPECT_EQ(m.why, NoValue::kNotMade) << m.name;
  EXPECT_FALSE(none.missing.empty());
  MetricSet all = Measure(Cut(Everything));
  EXPECT_EQ(ValueOf(all, "task_done_percent"), 100);
  EXPECT_GT(ValueOf(all, "damage_percent"), 500);
  EXPECT_EQ(ValueOf(all, "pulp_exposed_mm2"), 0) << "no surface is left";
  EXPECT_NEAR(ValueOf(all, "neighbour_removed_mm3"), 24, 1e-6 + 6 * tolerance_mm());
}

TEST_P(KnownFaults, AWiderOutlineAndAShortOneAreTold) {
  Planes wide, narrow;
  wide.mesial = [](const dvec3&) { return 0.4; };
  narrow.mesial = [](const dvec3&) { return -0.4; };
  // The mesial edge is more than 5 % of the outline.
  EXPECT_NEAR(ValueOf(Measure(Cut(wide)), "outline_over_mm"), 0.4, 4 * tolerance_mm());
  EXPECT_NEAR(ValueOf(Measure(Cut(wide)), "outline_short_mm"), 0, 4 * tolerance_mm());
  EXPECT_NEAR(ValueOf(Measure(Cut(narrow)), "outline_short_mm"), 0.4, 4 * tolerance_mm());
}

TEST_P(KnownFaults, TheCoverOfThePulpIsFoundWithinHalfAVoxel) {
  EXPECT_NEAR(ValueOf(Measure(reference_), "remaining_dentin_mm"), 1.2, 2.2 * tolerance_mm());
  Planes deep;
  deep.floor = [](const dvec3&) { return 0.8; };
  EXPECT_NEAR(ValueOf(Measure(Cut(deep)), "remaining_dentin_mm"), 0.4, 2.2 * tolerance_mm());
  deep.floor = [](const dvec3&) { return 1.4; };
  EXPECT_EQ(ValueOf(Measure(Cut(deep)), "remaining_dentin_mm"), 0);
}

INSTANTIATE_TEST_SUITE_P(Grids, KnownFaults,
                         testing::Values(Grid{100'000}, Grid{100'000, 0.0371},
                                         Grid{100'000, 0.0123, 7}, Grid{50'000, 0.0171},
                                         Grid{50'000, 0.0213, -6, true},
                                         Grid{25'000, 0.0093, 0, true}),
                         [](const auto& test) {
                           return std::to_string(test.param.voxel_nm / 1000) + "um" +
                                  (test.param.shift_mm > 0 ? "_off_grid" : "") +
                                  (test.param.turn_deg != 0 ? "_turned" : "");
                         });

}  // namespace
}  // namespace enamel::scoring
