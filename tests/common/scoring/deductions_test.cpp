#include "common/scoring/deductions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/cutting/cutter.h"
#include "common/scoring/task.h"
#include "common/scoring/zones.h"
#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

// A hand that cuts in strokes, a pose a tick, into a tooth that already has a cavity.
class Strokes {
 public:
  Strokes(const cutting::Volume& initial, const cutting::Volume& started)
      : volume_(started), moments_(initial), strokes_(SomeParams()) {
    volume_.Reserve();
    cutter_.emplace(volume_,
                    cutting::Bur{cutting::BurShape::kCylinder, kBurRadius_mm * 1e-3, 4e-3});
    // Removal before the tested strokes: all in the first tick.
    std::vector<int32_t> all;
    for (int b = 0; b < initial.spec().brick_count(); ++b) all.push_back(b);
    Tick(true, all);
    Lift();
  }

  void Lift() {
    for (int i = 0; i < 150; ++i) Tick(false, {});
  }
  void Along(dvec3 from_mm, dvec3 to_mm) {
    for (int i = 0; i <= 100; ++i) {
      cutting::RemovedUnits removed{};
      cutter_->Cut({(from_mm + (to_mm - from_mm) * (i / 100.0)) * 1e-3, {}}, removed);
      Tick(true, cutter_->touched());
    }
    Lift();
  }

  std::vector<Deduction> Find(const cutting::Volume& initial, const cutting::Volume& reference,
                              const std::vector<std::string>& criteria,
                              const std::vector<WorstPlace>& places = {}, int tooth = 0) const {
    const Provenance provenance = moments_.Take();
    const surface::Mesh surface = surface::ExtractSurface(reference);
    const surface::Mesh cut = CutPart(surface, CutVertices(surface, initial, reference));
    const scene::Exercise exercise = BlockExercise();
    scene::Scene scene = BlockScene();
    scene.tooth = tooth;
    return FindDeductions(
        scene, exercise.target, criteria,
        {&initial, &volume_, &reference, &cut, NearOf_m(exercise.target, initial.spec()),
         &provenance, &strokes_, &places});
  }

 private:
  void Tick(bool cutting, std::span<const int32_t> touched) {
    trace::Tick tick;
    core::TickOutput out;
    out.witness.force_sent_mn = {0, 0, cutting ? 50 : 0};
    out.removed[1] = cutting ? 1 : 0;
    strokes_.Add(tick, out);
    moments_.Add(volume_, touched);
  }

  cutting::Volume volume_;
  std::optional<cutting::Cutter> cutter_;
  ProvenanceRecorder moments_;
  StrokeRecorder strokes_;
};

const Deduction* Of(const std::vector<Deduction>& all, std::string_view criterion, bool left) {
  for (const Deduction& d : all) {
    if (d.criterion == criterion && d.left == left) return &d;
  }
  return nullptr;
}

// Stroke 1 is all that was cut as asked for. Stroke 2 takes 0.3 mm too much of the mesial wall,
// over 1.4 mm from the floor up; stroke 3 goes along it 0.1 mm deeper still; stroke 4 drills a hole
// where nothing was asked for.
class DeductionsTest : public testing::Test {
 protected:
  DeductionsTest()
      : initial(MakeBlock(100'000)), reference(CutCavity(initial, {})), hand(initial, reference) {
    hand.Along({1.3, -0.7, -2}, {1.3, 0.7, -2});
    hand.Along({1.4, -0.7, -2}, {1.4, 0.7, -2});
    hand.Along({-3, -2.3, 0.1}, {-3, -2.3, -0.6});
  }
  cutting::Volume initial, reference;
  Strokes hand;
};

TEST_F(DeductionsTest, AWallTooDeepNamesTheStrokesThatCutIt) {
  const auto found = hand.Find(initial, reference, {"wall_mesial_mm"});
  ASSERT_EQ(found.size(), 1u);
  const Deduction& d = found[0];
  EXPECT_FALSE(d.left);
  // A stadium's front swept 0.4 mm further: 0.4 mm over 1.4 mm and what the bur's sides sweep, by
  // 2 mm of height.
  EXPECT_GT(d.volume_m3, 0.4 * 1.4 * 2 * 1e-9);
  EXPECT_LT(d.volume_m3, 0.4 * 2.4 * 2.1 * 1e-9);
  ASSERT_EQ(d.stroke_count, 2u);
  EXPECT_EQ(d.strokes[0].number, 2u);
  EXPECT_EQ(d.strokes[1].number, 3u);
  // Within 1 mm of its worst place: 0.3 mm of the wall went first, 0.1 mm after it.
  EXPECT_TRUE(d.here);
  EXPECT_DOUBLE_EQ(d.strokes[0].volume_m3 + d.strokes[1].volume_m3, d.strokes_m3);
  EXPECT_GT(d.strokes_m3, 0.4 * d.volume_m3);
  EXPECT_LT(d.strokes_m3, d.volume_m3);
  EXPECT_GT(d.strokes[0].volume_m3, 2 * d.strokes[1].volume_m3);
  EXPECT_LT(d.strokes[0].volume_m3, 5 * d.strokes[1].volume_m3);  // voxels of 0.1 mm are whole
  EXPECT_NEAR(d.strokes[0].lasts_s, 0.1, 0.02);
  EXPECT_GE(d.half_tick, d.first_tick);
  EXPECT_LT(d.half_tick, d.strokes[1].first_tick) << "the first stroke took three quarters";
  // Tick 0, 150 of lift, then the stroke.
  EXPECT_EQ(d.first_tick, 151u);
  EXPECT_DOUBLE_EQ(d.first_s, 0.151);
  EXPECT_EQ(d.strokes[1].first_tick, 151u + 101 + 150);
  EXPECT_GT(d.position_m.x, 1.45e-3);
  EXPECT_LT(d.position_m.x, 2e-3);
  // The mesial wall looks to distal.
  EXPECT_LT(d.facing.x, -0.8);
}

TEST_F(DeductionsTest, TheStrokesOfAWallAreFoundByTheToothsNumber) {
  EXPECT_EQ(hand.Find(initial, reference, {"wall_distal_mm"}, {}, 46).size(), 1u);
  EXPECT_EQ(hand.Find(initial, reference, {"wall_mesial_mm"}, {}, 46).size(), 0u);
}

TEST_F(DeductionsTest, WhatIsCutElsewhereIsThePlaceOfDamageAndOfNoWall) {
  const auto found = hand.Find(initial, reference, {"outside_removed_mm3", "wall_distal_mm"});
  const Deduction* hole = Of(found, "outside_removed_mm3", false);
  ASSERT_TRUE(hole);
  // Two faults: the hole, and the wall beyond the leeway. The hole is a stroke of its own.
  auto of_hole = std::find_if(hole->strokes.begin(), hole->strokes.end(),
                              [](const FaultStroke& s) { return s.number == 4; });
  ASSERT_NE(of_hole, hole->strokes.end());
  // Its voxels are whole ones: known to half a voxel over its side and bottom.
  EXPECT_NEAR(of_hole->volume_m3, M_PI * 0.25 * 0.6 * 1e-9, M_PI * (0.6 + 0.25) * 0.05e-9);
  // More than 1 mm from the wall.
  const Deduction* wall = Of(found, "wall_distal_mm", false);
  EXPECT_TRUE(!wall || wall->strokes.empty());
}

TEST_F(DeductionsTest, AMetricWithAPlaceOfItsOwnLiesThereWithTheStrokesNearIt) {
  const dvec3 on_wall(1.8e-3, 0, -1e-3), mesially(-1, 0, 0), far(0, 0, 3e-3), up(0, 0, 1);
  const auto found = hand.Find(initial, reference, {"convergence_most_deg", "finish_depth_mm"},
                               {{"convergence_most_deg", on_wall, mesially},
                                {"finish_depth_mm", far, up},
                                {"finish_waviness_mm", far, up}});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].criterion, "convergence_most_deg");
  EXPECT_FALSE(found[0].left);
  EXPECT_EQ(found[0].position_m, on_wall);
  EXPECT_EQ(found[0].facing, mesially);
  EXPECT_EQ(found[0].stroke_count, 2u) << "not the hole, which is far away";
  EXPECT_EQ(found[0].first_tick, 151u);
  // Nothing differs there: the place alone.
  EXPECT_EQ(found[1].criterion, "finish_depth_mm");
  EXPECT_FALSE(found[1].left);
  EXPECT_EQ(found[1].position_m, far);
  EXPECT_EQ(found[1].volume_m3, 0);
  EXPECT_EQ(found[1].stroke_count, 0u);
}

// A stroke that grazes the wall is nothing that one has to stop; the one that goes through it is.
TEST(DeductionsOfLittleTest, ItBeganWithTheFirstStrokeThatCounts) {
  const cutting::Volume initial = MakeBlock(100'000), reference = CutCavity(initial, {});
  Strokes hand(initial, reference);
  hand.Along({1.08, -0.7, -2}, {1.08, 0.7, -2});
  hand.Along({1.6, -0.7, -2}, {1.6, 0.7, -2});
  const auto found = hand.Find(initial, reference, {"wall_mesial_mm"});
  ASSERT_EQ(found.size(), 1u);
  ASSERT_EQ(found[0].stroke_count, 2u);
  EXPECT_EQ(found[0].strokes[0].number, 3u);
  EXPECT_EQ(found[0].first_tick, 151u + 101 + 150);
}

// A fault that spreads over a surface is placed where it is worst: another stroke's work far from
// there does not set its moment.
TEST(DeductionsOfLittleTest, StrokesAndMomentsAreOfTheMarkedPlace) {
  const cutting::Volume initial = MakeBlock(100'000), reference = CutCavity(initial, {});
  Strokes hand(initial, reference);
  hand.Along({-1.2, -0.7, -2}, {-1.2, 0.7, -2});  // distally 0.2 mm too much
  hand.Along({1.6, -0.7, -2}, {1.6, 0.7, -2});    // mesially 0.6 mm
  const auto found = hand.Find(initial, reference, {"overcut_mm3"});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].here);
  EXPECT_GT(found[0].position_m.x, 1.4e-3);
  ASSERT_EQ(found[0].stroke_count, 1u);
  EXPECT_EQ(found[0].strokes[0].number, 3u);
  EXPECT_EQ(found[0].first_tick, 151u + 101 + 150);
}

TEST_F(DeductionsTest, ForceAndTimeHaveNoPlace) {
  EXPECT_TRUE(hand.Find(initial, reference, {"force_sent_p95_n", "time_s", "unheard_of"}).empty());
  EXPECT_TRUE(hand.Find(initial, reference, {}).empty());
}

TEST(DeductionsOfLittleTest, WhatWasLeftHasAPlaceAndNoMoment) {
  const cutting::Volume initial = MakeBlock(100'000);
  const cutting::Volume reference = CutCavity(initial, {});
  Cavity small;
  small.distal_mm = 1.1;
  const Strokes hand(initial, CutCavity(initial, small));
  const auto found = hand.Find(initial, reference, {"missed_mm3", "wall_distal_mm"});
  const Deduction* missed = Of(found, "missed_mm3", true);
  ASSERT_TRUE(missed);
  // 0.4 mm of a wall 2.4 mm wide and 2 mm high, the corners' radius moved along with it.
  EXPECT_NEAR(missed->volume_m3, 0.4 * 2.4 * 2 * 1e-9, 2.4 * 2 * 0.025e-9);
  EXPECT_TRUE(missed->strokes.empty());
  EXPECT_EQ(missed->first_tick, 0u);
  EXPECT_LT(missed->position_m.x, -1.1e-3);
  EXPECT_TRUE(Of(found, "wall_distal_mm", true));
  EXPECT_FALSE(Of(found, "wall_distal_mm", false));
}

TEST(DeductionsOfLittleTest, TheReferenceItselfHasNone) {
  const cutting::Volume initial = MakeBlock(100'000);
  const cutting::Volume reference = CutCavity(initial, {});
  const Strokes hand(initial, reference);
  EXPECT_TRUE(
      hand.Find(initial, reference, {"deviation_rms_mm", "missed_mm3", "overcut_mm3"}).empty());
  // An untouched tooth: all of the task is left, and no stroke is blamed.
  const Strokes nothing(initial, initial);
  const auto found = nothing.Find(initial, reference, {"task_done_percent", "damage_percent"});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].left);
}

}  // namespace
}  // namespace enamel::scoring
