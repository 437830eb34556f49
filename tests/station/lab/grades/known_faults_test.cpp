#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "common/scoring/deviation.h"
#include "station/lab/grades/hollow.h"
#include "tests/common/scoring/synthetic_cavity.h"

// Faults made by formula, on and off the grid, at three voxel sizes: each metric finds its own
// fault within a quarter of a voxel (volumes: area times that) or half a degree, and unrelated
// metrics do not change. The lab's generator fills the volumes from closed forms; no cutter made
// them.
namespace enamel::station::lab {
namespace {

using namespace scoring;

using cutting::Volume;

constexpr double kMm = 1e-3;
constexpr double kDepth_mm = 2;  // of BlockExercise's target

struct Grid {
  int32_t voxel_nm;
  double shift_mm = 0;     // of the whole grid
  double turn_deg = 0;     // of what is cut, about +z
  bool only_full = false;  // by ./check --full only: long
};

Hollow Box_mm(const dvec3& lo_mm, const dvec3& hi_mm) {
  return [=](const dvec3& p) { return BoxDistance_m(p, lo_mm * kMm, hi_mm * kMm); };
}
Hollow Taken(const BoxCavity& cavity) {
  return [cavity](const dvec3& p) { return cavity.Distance_m(p); };
}
// The cavity of the exercise with one changed face.
BoxCavity With(scoring::Part part, const Face& face) {
  BoxCavity out = FaultBlockCavity();
  out.faces[part] = face;
  return out;
}
BoxCavity Leaning(double degrees) {
  return With(scoring::kMesial, {.slope = std::tan(degrees * std::numbers::pi / 180)});
}

struct Filling {
  Volume volume;
  surface::Mesh mesh;
  ProcessRecorder process = StraightRecording(1000, 1, 1);
  explicit Filling(Volume v) : volume(std::move(v)), mesh(surface::ExtractSurface(volume)) {}
};

class KnownFaults : public testing::TestWithParam<Grid> {
 protected:
  // A grid used only by ./check --full is filled coarsely when it is skipped.
  KnownFaults()
      : initial_(FaultBlock({Used().voxel_nm, Used().shift_mm * kMm})),
        reference_(CutAway(initial_, Turned(Taken(FaultBlockCavity()), Used().turn_deg))) {}
  void SetUp() override {
    if (!Runs()) GTEST_SKIP() << "takes minutes: ./check --full";
  }
  static bool Runs() { return !GetParam().only_full || std::getenv("ENAMEL_FULL") != nullptr; }
  static Grid Used() { return Runs() ? GetParam() : Grid{400'000}; }

  Filling Cut(const Hollow& hollow) const {
    return Filling(CutAway(initial_, Turned(hollow, GetParam().turn_deg)));
  }
  Filling Cut(const BoxCavity& cavity) const { return Cut(Taken(cavity)); }
  // The reference's cavity and something more.
  Filling CutAlso(Hollow more) const {
    return Cut(Both(Taken(FaultBlockCavity()), std::move(more)));
  }
  MetricSet Measure(const Filling& attempt) const {
    return Measure(attempt, reference_, BlockExercise());
  }
  MetricSet Measure(const Filling& attempt, const Filling& reference,
                    const scene::Exercise& exercise) const {
    auto data = [&](const Filling& f) {
      return AttemptData{&initial_, &f.volume, &f.mesh, &f.process};
    };
    auto metrics = ComputeMetrics(BlockScene(), exercise, data(attempt), data(reference));
    EXPECT_TRUE(metrics.ok()) << metrics.status().message();
    return metrics.ok() ? *metrics : MetricSet{};
  }
  double tolerance_mm() const { return GetParam().voxel_nm * 1e-6 / 4; }

  const Volume initial_;
  const Filling reference_;
};

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
    EXPECT_NEAR(ValueOf(m, "divergence_mesial_deg"), degrees, 0.5) << degrees;
    EXPECT_NEAR(ValueOf(m, "divergence_distal_deg"), 0, 0.5) << degrees;
    EXPECT_NEAR(ValueOf(m, "wall_tilt_deg"), std::fabs(degrees), 0.5) << degrees;
    EXPECT_NEAR(ValueOf(m, "undercut_deg"), std::max(0.0, -degrees), 0.5) << degrees;
    EXPECT_NEAR(ValueOf(m, "tilt_distal_deg"), 0, 0.5) << degrees;
    EXPECT_NEAR(ValueOf(m, "tilt_floor_deg"), 0, 0.5) << degrees;
  }
}

// The next wall is nearer than this one has moved.
TEST_P(KnownFaults, InANarrowCavityAWallAMillimetreOffIsFound) {
  scene::Exercise exercise = BlockExercise();
  exercise.target.half_size_um = {1'500, 600, 0};
  exercise.target.depth_um = 1'200;
  BoxCavity asked = FaultBlockCavity();
  asked.half_y_m = 0.6 * kMm, asked.depth_m = 1.2 * kMm;
  const Filling reference = Cut(asked);
  const struct {
    scoring::Part part;
    const char* metric;
  } faces[] = {{kDistal, "wall_distal_mm"}, {kBuccal, "wall_buccal_mm"}, {kFloor, "floor_mm"}};
  for (const auto& face : faces) {
    BoxCavity off = asked;
    off.faces[face.part].moved_m = 1 * kMm;
    MetricSet m = Measure(Cut(off), reference, exercise);
    EXPECT_NEAR(ValueOf(m, face.metric), 1, tolerance_mm()) << face.metric;
  }
}

TEST_P(KnownFaults, ATiltedFloorIsFoundWithinHalfADegree) {
  for (double degrees : {1.0, 5.0, 15.0}) {
    MetricSet m = Measure(Cut(With(kFloor, {.slope = std::tan(degrees * std::numbers::pi / 180)})));
    EXPECT_NEAR(ValueOf(m, "tilt_floor_deg"), degrees, 0.5) << degrees;
    EXPECT_NEAR(ValueOf(m, "wall_tilt_deg"), 0, 0.5) << degrees;
  }
}

TEST_P(KnownFaults, AWavyWallIsFoundWithinAQuarterVoxel) {
  for (double size_mm : {0.05, 0.1, 0.2}) {
    MetricSet m = Measure(Cut(With(kMesial, {.wave_m = size_mm * kMm})));
    EXPECT_NEAR(ValueOf(m, "wall_waviness_mm"), size_mm / std::sqrt(2.0), tolerance_mm())
        << size_mm;
    EXPECT_LT(ValueOf(m, "floor_waviness_mm"), tolerance_mm());
  }
}

// The cavity is 3 x 2.4 mm and 2 mm deep: 0.4 mm away from its walls and its floor 2.2 x 1.6 mm are left, 1.6 mm high.
TEST_P(KnownFaults, APillarASeptumAndALidAreLeftStanding) {
  const BoxCavity asked = FaultBlockCavity();
  const dvec3 middle = asked.centre_m / kMm;
  const struct {
    dvec3 half_mm;  // up from `from_mm`
    double from_mm, counts_mm3, area_mm2;
  } left[] = {{{0.2, 0.2, 9}, -9, 0.4 * 0.4 * 1.6, 4 * 0.4 * 1.6 + 0.16},
              {{0.1, 9, 9}, -9, 0.2 * 1.6 * 1.6, 2 * 1.6 * 1.6 + 2 * 0.2 * (1.6 + 1.6)},
              {{9, 9, 9}, -0.2, 0.2 * 2.2 * 1.6, 2.2 * 1.6 + 0.2 * 2 * (2.2 + 1.6)}};
  for (const auto& each : left) {
    dvec3 lo = middle - each.half_mm, hi = middle + each.half_mm;
    lo.z = middle.z + each.from_mm, hi.z = 9;
    const Hollow spared = Box_mm(lo, hi), cut = Taken(asked);
    MetricSet m = Measure(Cut([=](const dvec3& p) { return std::max(cut(p), -spared(p)); }));
    EXPECT_NEAR(ValueOf(m, "left_standing_mm3"), each.counts_mm3, each.area_mm2 * tolerance_mm());
  }
}

// Material short of a wall or of the floor counts there, and is neither left standing nor a slope
// of the floor.
TEST_P(KnownFaults, ACavityThatIsTooSmallHasALevelFloorAndNothingStands) {
  for (double short_mm : {0.1, 0.2, 0.3}) {
    BoxCavity small = FaultBlockCavity();
    for (auto part : {kMesial, kDistal, kBuccal, kLingual})
      small.faces[part].moved_m = -short_mm * kMm;
    MetricSet m = Measure(Cut(small));
    EXPECT_NEAR(ValueOf(m, "tilt_floor_deg"), 0, 0.5) << short_mm;
    EXPECT_LT(ValueOf(m, "floor_waviness_mm"), 0.03) << short_mm;
    EXPECT_NEAR(ValueOf(m, "wall_tilt_deg"), 0, 0.5) << short_mm;
    EXPECT_NEAR(ValueOf(m, "wall_mesial_mm"), -short_mm, tolerance_mm());
    EXPECT_NEAR(ValueOf(m, "left_standing_mm3"), 0, 0.01) << short_mm;
  }
}

// A fault that grows until it is no longer part of the floor or the wall must not become cheaper.
TEST_P(KnownFaults, ADitchAndALumpAreNoLessUnevenTheLargerTheyAre) {
  const BoxCavity asked = FaultBlockCavity();
  const dvec3 middle = asked.centre_m / kMm;
  double floor = 0, wall = 0;
  for (double size_mm : {0.1, 0.2, 0.3, 0.5, 0.7}) {
    const dvec3 lo(middle.x - 0.9, middle.y - 0.2, middle.z - 2 - size_mm);
    MetricSet ditch = Measure(CutAlso(Box_mm(lo, {middle.x + 0.9, middle.y + 0.2, middle.z})));
    EXPECT_GE(ValueOf(ditch, "floor_waviness_mm"), floor - 1e-3) << size_mm;
    floor = ValueOf(ditch, "floor_waviness_mm");
    const double buccal = middle.y + 1.2;
    const Hollow lump = Box_mm({middle.x - 0.4, buccal - size_mm, -9}, {middle.x + 0.4, 9, 9});
    const Hollow cut = Taken(asked);
    MetricSet lumpy = Measure(Cut([=](const dvec3& p) { return std::max(cut(p), -lump(p)); }));
    EXPECT_GE(ValueOf(lumpy, "wall_waviness_mm"), wall - 0.01) << size_mm;
    wall = ValueOf(lumpy, "wall_waviness_mm");
  }
  EXPECT_GT(floor, 0.05);
  EXPECT_GT(wall, 0.05);
}

TEST_P(KnownFaults, AnotherHoleIsCutElsewhereAndNotBesideTheWalls) {
  const dvec3 lo(-3.2, -2.8, -1), hi(-2.4, 2.8, 9);
  MetricSet m = Measure(CutAlso(Box_mm(lo, hi)));
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
  MetricSet m = Measure(CutAlso([&](const dvec3& p) { return -shaved_mm * kMm - p.z; }));
  // All of the top but the opening and its leeway of 0.2 mm.
  const double leeway = 0.2, near = (3 + 2 * leeway) * (2.4 + 2 * leeway), top = 7 * 6 + 1 * 6;
  EXPECT_NEAR(ValueOf(m, "outside_removed_mm3") + ValueOf(m, "neighbour_removed_mm3"),
              (top - near) * shaved_mm, top * tolerance_mm());
  // Only the rim of the walls disappears with it.
  EXPECT_LT(ValueOf(m, "deviation_rms_mm"), 0.02);
  EXPECT_GE(ValueOf(m, "deviation_rms_mm"), 0);
}

TEST_P(KnownFaults, WhatIsTakenFromTheNeighbourIsItsVolumeAndDepth) {
  const dvec3 lo(3.0, -0.5, -1), hi(4.0, 0.5, 9);
  MetricSet m = Measure(CutAlso(Box_mm(lo, hi)));
  const double area = 2 * 1 * (0.3 + 1) + 0.3;
  EXPECT_NEAR(ValueOf(m, "neighbour_removed_mm3"), 0.3 * 1 * 1, area * tolerance_mm());
  // Of a turned box the corner goes deepest.
  const double turn = std::fabs(GetParam().turn_deg) * std::numbers::pi / 180;
  const double depth = hi.x * std::cos(turn) + hi.y * std::sin(turn) - kBlockNeighbour_m / kMm;
  EXPECT_NEAR(ValueOf(m, "neighbour_depth_mm"), depth, 2 * tolerance_mm());
  EXPECT_EQ(ValueOf(Measure(reference_), "neighbour_removed_mm3"), 0);
}

TEST_P(KnownFaults, CariesThatWasLeftIsCariesAndWhatWasTakenIsNotSoundTissue) {
  // Half a millimetre short of the floor: the ball's cap between is left.
  MetricSet m = Measure(Cut(With(kFloor, {.moved_m = -0.5 * kMm})));
  auto cap = [](double height) {  // of the ball above a plane
    return std::numbers::pi * height * height * (kBlockCaries_m / kMm - height / 3);
  };
  const double above_floor = (BlockCariesMiddle_m().z + kBlockCaries_m) / kMm + kDepth_mm;
  const double task = cap(above_floor), left = task - cap(above_floor - 0.5);
  // The label's boundary is whole voxels: half a voxel off at the worst, on average none.
  EXPECT_NEAR(ValueOf(m, "caries_left_mm3"), left, 1.1 * tolerance_mm());
  EXPECT_NEAR(ValueOf(m, "caries_left_percent"), 100 * left / task, 6);
  EXPECT_NEAR(ValueOf(m, "sound_removed_mm3"), 0, 1e-6);
  EXPECT_NEAR(ValueOf(m, "missed_mm3"), 0.5 * 3 * 2.4, (3 * 2.4 + 2 * 5.4) * tolerance_mm());
}

TEST_P(KnownFaults, AnUntouchedToothHasDoneNothingAndADestroyedOneEverythingElse) {
  MetricSet none = Measure(Cut(NothingTaken));
  EXPECT_EQ(ValueOf(none, "task_done_percent"), 0);
  EXPECT_EQ(ValueOf(none, "damage_percent"), 0);
  EXPECT_GT(ValueOf(none, "deviation_rms_mm"), 0.5);
  size_t not_made = 0;
  for (const MissingMetric& m : none.missing) {
    if (m.why == NoValue::kNotMade) {
      ++not_made;
      continue;
    }
    // A cavity without a neighbour lacks a crown's walls, stump and finish line, and a contact.
    const bool of_others =
        std::ranges::any_of(std::array{"convergence_", "crown_", "reduction_", "finish_", "bevel_",
                                       "stump_", "contact_"},
                            [&](const char* beginning) { return m.name.starts_with(beginning); });
    EXPECT_TRUE(of_others) << m.name;
    EXPECT_EQ(m.why, NoValue::kNotInTask) << m.name;
  }
  EXPECT_GT(not_made, 0u);
  MetricSet all = Measure(Cut(EverythingTaken));
  EXPECT_EQ(ValueOf(all, "task_done_percent"), 100);
  EXPECT_GT(ValueOf(all, "damage_percent"), 500);
  EXPECT_EQ(ValueOf(all, "pulp_exposed_mm2"), 0) << "no surface is left";
  EXPECT_NEAR(ValueOf(all, "neighbour_removed_mm3"), 24, 1e-6 + 6 * tolerance_mm());
}

TEST_P(KnownFaults, AWiderOutlineAndAShortOneAreTold) {
  const BoxCavity wide = With(kMesial, {.moved_m = 0.4 * kMm});
  const BoxCavity narrow = With(kMesial, {.moved_m = -0.4 * kMm});
  // The mesial edge is more than 5 % of the outline.
  EXPECT_NEAR(ValueOf(Measure(Cut(wide)), "outline_over_mm"), 0.4, 4 * tolerance_mm());
  EXPECT_NEAR(ValueOf(Measure(Cut(wide)), "outline_short_mm"), 0, 4 * tolerance_mm());
  EXPECT_NEAR(ValueOf(Measure(Cut(narrow)), "outline_short_mm"), 0.4, 4 * tolerance_mm());
}

TEST_P(KnownFaults, TheCoverOfThePulpIsFoundWithinHalfAVoxel) {
  EXPECT_NEAR(ValueOf(Measure(reference_), "remaining_dentin_mm"), 1.2, 2.2 * tolerance_mm());
  auto deeper = [](double mm) { return With(kFloor, {.moved_m = mm * kMm}); };
  EXPECT_NEAR(ValueOf(Measure(Cut(deeper(0.8))), "remaining_dentin_mm"), 0.4, 2.2 * tolerance_mm());
  EXPECT_EQ(ValueOf(Measure(Cut(deeper(1.4))), "remaining_dentin_mm"), 0);
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
}  // namespace enamel::station::lab
