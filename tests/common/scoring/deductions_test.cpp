#include "common/scoring/deductions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "common/cutting/cutter.h"
#include "common/scoring/score.h"
#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

using cutting::Volume;

scene::Rubric Prices() {
  scene::Rubric out;
  out.prices = {{"floor", 0.45, 0.6, 14, 42, 2, 14, "a test"},
                {"wall", 0.45, 0.6, 12, 36, 2, 12, "a test"},
                {"line_angle", 0.6, 0.6, 5, 6, 1, 5, "a test"},
                {"elsewhere", 1, 0, 12, 60, 2, 12, "a test"},
                {"pulp", 1, 0, 1000, 1000, 1, 5, "a test"}};
  return out;
}

// What was found of an attempt.
struct Explained {
  std::vector<Mistake> mistakes;
  std::vector<Deduction> deductions;

  // Of the first mistake of this kind.
  const Deduction* Of(MistakeKind kind, bool left = false) const {
    for (const Deduction& d : deductions) {
      if (mistakes.at(d.mistake).kind == kind && d.left == left) return &d;
    }
    return nullptr;
  }
  std::ptrdiff_t Count(bool left) const {
    return std::ranges::count(deductions, left, &Deduction::left);
  }
};

// A hand that cuts in strokes, a pose a tick, into a tooth that already has a cavity.
class Strokes {
 public:
  Strokes(const Volume& initial, const Volume& started)
      : initial_(initial), volume_(started), moments_(initial), strokes_(SomeParams()) {
    volume_.Reserve();
    cutter_.emplace(volume_,
                    cutting::Bur{cutting::BurShape::kCylinder, kBurRadius_mm * 1e-3, 4e-3});
    // Removal before the tested strokes: all in the first tick.
    std::vector<int32_t> all;
    for (int b = 0; b < initial.spec().brick_count(); ++b) all.push_back(b);
    Tick(true, all);
    Lift();
  }

  // One stroke through all of the points.
  void Along(const std::vector<dvec3>& points_mm) {
    for (size_t k = 1; k < points_mm.size(); ++k) {
      const dvec3 from = points_mm[k - 1], way = points_mm[k] - from;
      for (int i = 0; i <= kTicksOfALine; ++i) {
        cutting::RemovedUnits removed{};
        cutter_->Cut({(from + way * (i * 1.0 / kTicksOfALine)) * 1e-3, {}}, removed);
        Tick(true, cutter_->touched());
      }
    }
    Lift();
  }

  Explained Find(const Volume& reference) const {
    const Provenance provenance = moments_.Take();
    const AcceptableCut r(initial_, reference, {});
    const auto judged = JudgeCut(r, volume_, Prices());
    EXPECT_TRUE(judged.ok()) << judged.status().message();
    if (!judged.ok()) return {};
    return {judged->found.mistakes,
            FindDeductions({&r, &volume_, &judged->found, &provenance, &strokes_})};
  }

  static constexpr int kTicksOfALine = 100, kTicksOfALift = 150;
  // Of the strokes of one line each, the first of which is number 2.
  static uint64_t FirstTickOf(uint32_t stroke) {
    return 1 + kTicksOfALift + (stroke - 2) * (kTicksOfALine + 1 + kTicksOfALift);
  }

 private:
  void Lift() {
    for (int i = 0; i < kTicksOfALift; ++i) Tick(false, {});
  }
  void Tick(bool cutting, std::span<const int32_t> touched) {
    trace::Tick tick;
    core::TickOutput out;
    out.witness.force_computed_mn = {0, 0, cutting ? 50 : 0};
    out.removed[1] = cutting ? 1 : 0;
    strokes_.Add(tick, out);
    moments_.Add(volume_, touched);
  }

  const Volume& initial_;
  Volume volume_;
  std::optional<cutting::Cutter> cutter_;
  ProvenanceRecorder moments_;
  StrokeRecorder strokes_;
};

// Stroke 1 is all that was cut as asked for.
class DeductionsTest : public testing::Test {
 protected:
  DeductionsTest()
      : initial(MakeBlock(100'000)), reference(CutCavity(initial, {})), hand(initial, reference) {}
  Explained Find() const { return hand.Find(reference); }

  const Volume initial, reference;
  Strokes hand;
};

TEST_F(DeductionsTest, AFloorCutTooDeepNamesTheStrokeThatCutIt) {
  constexpr double kDeep_mm = 0.4, kX = 1, kY = 0.7;
  std::vector<dvec3> zigzag;
  for (int i = 0; i <= 4; ++i) {
    const double y = kY * (i - 2) / 2, x = i % 2 == 0 ? -kX : kX;
    zigzag.insert(zigzag.end(), {dvec3(x, y, -2 - kDeep_mm), dvec3(-x, y, -2 - kDeep_mm)});
  }
  hand.Along(zigzag);
  const Explained found = Find();
  ASSERT_FALSE(found.mistakes.empty());
  EXPECT_EQ(found.mistakes[0].kind, MistakeKind::kDeep);
  EXPECT_EQ(found.mistakes[0].place, "floor");
  EXPECT_NEAR(found.mistakes[0].size, kDeep_mm, 0.1);
  const Deduction* d = found.Of(MistakeKind::kDeep);
  ASSERT_TRUE(d);
  EXPECT_EQ(found.Count(true), 0);
  EXPECT_EQ(d->mistake, 0U);
  // All of the floor, its corners round: known to half a voxel of its depth.
  const double area_mm2 = 3 * 2.4 - (4 - std::numbers::pi) * kBurRadius_mm * kBurRadius_mm;
  EXPECT_NEAR(d->volume_m3, area_mm2 * kDeep_mm * 1e-9, area_mm2 * 0.05e-9);
  ASSERT_EQ(d->stroke_count, 1U);
  ASSERT_EQ(d->strokes.size(), 1U);
  EXPECT_EQ(d->strokes[0].number, 2U);
  EXPECT_TRUE(d->here);
  EXPECT_GE(d->first_tick, Strokes::FirstTickOf(2));
  EXPECT_DOUBLE_EQ(d->first_s, static_cast<double>(d->first_tick) * 1e-3);
  EXPECT_GE(d->half_tick, d->first_tick);
  EXPECT_DOUBLE_EQ(d->strokes[0].volume_m3, d->strokes_m3);
  EXPECT_LT(d->strokes_m3, d->volume_m3) << "within a millimetre of the worst place";
  EXPECT_LT(d->position_m.z, -2e-3);
  EXPECT_GT(d->position_m.z, -2.4e-3);
  EXPECT_GT(d->facing.z, 0.8);
}

TEST_F(DeductionsTest, AWallTooFarOutIsNamedWithTheStrokesThatCutIt) {
  hand.Along({{1.3, -0.7, -2}, {1.3, 0.7, -2}});
  hand.Along({{1.4, -0.7, -2}, {1.4, 0.7, -2}});
  const Explained found = Find();
  ASSERT_FALSE(found.mistakes.empty());
  EXPECT_EQ(found.mistakes[0].kind, MistakeKind::kOverExtended);
  EXPECT_EQ(found.mistakes[0].place, "wall_mesial");
  const Deduction* d = found.Of(MistakeKind::kOverExtended);
  ASSERT_TRUE(d);
  // A stadium's front swept 0.4 mm further: 0.4 mm over 1.4 mm and what the bur's sides sweep, by
  // 2 mm of height.
  EXPECT_GT(d->volume_m3, 0.4 * 1.4 * 2 * 1e-9);
  EXPECT_LT(d->volume_m3, 0.4 * 2.4 * 2.1 * 1e-9);
  ASSERT_EQ(d->stroke_count, 2U);
  // 0.3 mm went first, 0.1 mm after it; voxels of 0.1 mm are whole.
  EXPECT_EQ(d->strokes[0].number, 2U);
  EXPECT_EQ(d->strokes[1].number, 3U);
  EXPECT_GT(d->strokes[0].volume_m3, 2 * d->strokes[1].volume_m3);
  EXPECT_LT(d->strokes[0].volume_m3, 5 * d->strokes[1].volume_m3);
  EXPECT_DOUBLE_EQ(d->strokes[0].volume_m3 + d->strokes[1].volume_m3, d->strokes_m3);
  EXPECT_NEAR(d->strokes[0].lasts_s, 0.1, 0.02);
  EXPECT_EQ(d->first_tick, Strokes::FirstTickOf(2));
  EXPECT_EQ(d->strokes[1].first_tick, Strokes::FirstTickOf(3));
  EXPECT_LT(d->half_tick, d->strokes[1].first_tick) << "the first stroke took three quarters";
  EXPECT_GT(d->position_m.x, 1.45e-3);
  EXPECT_LT(d->position_m.x, 2e-3);
  // The wall looks back over the cavity.
  EXPECT_LT(d->facing.x, -0.8);
}

// A stroke that grazes the wall is nothing that one has to stop; the one that goes through it is.
TEST_F(DeductionsTest, ItBeganWithTheFirstStrokeThatCounts) {
  hand.Along({{1.12, -0.05, -2}, {1.12, 0.05, -2}});
  hand.Along({{1.6, -0.7, -2}, {1.6, 0.7, -2}});
  const Explained found = Find();
  const Deduction* d = found.Of(MistakeKind::kOverExtended);
  ASSERT_TRUE(d);
  ASSERT_EQ(d->stroke_count, 2U);
  EXPECT_EQ(d->strokes[0].number, 3U);
  EXPECT_EQ(d->first_tick, Strokes::FirstTickOf(3));
}

TEST_F(DeductionsTest, APitAwayFromTheTaskIsAHoleOfTheStrokeThatDrilledIt) {
  constexpr double kDeep_mm = 0.6;
  hand.Along({{1.3, -0.7, -2}, {1.3, 0.7, -2}});
  hand.Along({{-3, -2.3, 0.1}, {-3, -2.3, -kDeep_mm}});
  const Explained found = Find();
  const Deduction* hole = found.Of(MistakeKind::kHole);
  ASSERT_TRUE(hole);
  EXPECT_FALSE(hole->left);
  ASSERT_EQ(hole->stroke_count, 1U);
  EXPECT_EQ(hole->strokes[0].number, 3U);
  // Known to half a voxel over its side and bottom.
  const double r = kBurRadius_mm, side_mm2 = std::numbers::pi * (2 * r * kDeep_mm + r * r);
  EXPECT_NEAR(hole->volume_m3, std::numbers::pi * r * r * kDeep_mm * 1e-9, side_mm2 * 0.05e-9);
  EXPECT_NEAR(hole->position_m.x, -3e-3, 0.3e-3);
  EXPECT_NEAR(hole->position_m.y, -2.3e-3, 0.3e-3);
}

// Strokes and moments are of the marked place: what another stroke did far from there does not set them.
TEST_F(DeductionsTest, OfTwoHolesTheLargerIsThePlaceAndNamesItsStroke) {
  hand.Along({{-3, -2.3, 0.1}, {-3, -2.3, -0.4}});
  hand.Along({{3, 2.3, 0.1}, {3, 2.3, -1}});
  const Explained found = Find();
  const Deduction* hole = found.Of(MistakeKind::kHole);
  ASSERT_TRUE(hole);
  EXPECT_EQ(std::ranges::count(found.mistakes, MistakeKind::kHole, &Mistake::kind), 1);
  EXPECT_GT(hole->position_m.x, 2e-3);
  EXPECT_TRUE(hole->here);
  ASSERT_EQ(hole->stroke_count, 1U);
  EXPECT_EQ(hole->strokes[0].number, 3U);
  EXPECT_LT(hole->strokes_m3, 0.9 * hole->volume_m3);
}

// Of the pulp, which lies 0.8 mm under the floor, nothing is to be taken: every touch of it counts, wherever it is.
TEST_F(DeductionsTest, APulpThatWasOpenedNamesEveryStrokeInIt) {
  hand.Along({{-1, 0, -2}, {-1, 0, -3}});
  hand.Along({{1, 0, -2}, {1, 0, -3.1}});
  const Explained found = Find();
  const Deduction* pulp = found.Of(MistakeKind::kPulp);
  ASSERT_TRUE(pulp);
  EXPECT_FALSE(pulp->here);
  ASSERT_EQ(pulp->stroke_count, 2U);
  EXPECT_EQ(pulp->strokes[0].number, 3U) << "it went deeper";
  EXPECT_GE(pulp->first_tick, Strokes::FirstTickOf(2));
  EXPECT_LT(pulp->first_tick, Strokes::FirstTickOf(3));
  EXPECT_LT(pulp->position_m.z, -2.7e-3);
}

TEST_F(DeductionsTest, WhatWasLeftHasAPlaceAndNoMoment) {
  Cavity small;
  small.distal_mm = 1.1;
  const Explained found = Strokes(initial, CutCavity(initial, small)).Find(reference);
  EXPECT_EQ(found.Count(false), 0);
  ASSERT_FALSE(found.mistakes.empty());
  EXPECT_EQ(found.mistakes[0].kind, MistakeKind::kUnderExtended);
  EXPECT_EQ(found.mistakes[0].place, "wall_distal");
  const Deduction* d = found.Of(MistakeKind::kUnderExtended, true);
  ASSERT_TRUE(d);
  // 0.4 mm of a wall 2.4 mm wide and 2 mm high, the corners' radius moved along with it.
  EXPECT_NEAR(d->volume_m3, 0.4 * 2.4 * 2 * 1e-9, 2.4 * 2 * 0.025e-9);
  EXPECT_TRUE(d->strokes.empty());
  EXPECT_EQ(d->stroke_count, 0U);
  EXPECT_EQ(d->first_tick, 0U);
  EXPECT_LT(d->position_m.x, -1.1e-3);
}

TEST_F(DeductionsTest, TheTargetItselfHasNoneAndAnUntouchedToothBlamesNoStroke) {
  const Explained exact = Find();
  EXPECT_TRUE(exact.mistakes.empty());
  EXPECT_TRUE(exact.deductions.empty());
  const Explained untouched = Strokes(initial, initial).Find(reference);
  EXPECT_EQ(untouched.Count(false), 0);
  EXPECT_GT(untouched.Count(true), 0);
  double left_m3 = 0;
  for (const Deduction& d : untouched.deductions) {
    EXPECT_EQ(d.stroke_count, 0U);
    left_m3 += d.volume_m3;
  }
  // All of the task: the box of 3 x 2.4 x 2 mm, its upright edges round.
  const double round_mm2 = (4 - std::numbers::pi) * kBurRadius_mm * kBurRadius_mm;
  EXPECT_NEAR(left_m3, (3 * 2.4 - round_mm2) * 2 * 1e-9, 0.5e-9);
}

TEST_F(DeductionsTest, AreInTheOrderOfTheMistakesTooMuchTakenFirst) {
  Cavity small;
  small.distal_mm = 1.1;
  Strokes both(initial, CutCavity(initial, small));
  both.Along({{1.3, -0.7, -2}, {1.3, 0.7, -2}});
  both.Along({{-3, 2.3, 0.1}, {-3, 2.3, -0.6}});
  const auto found = both.Find(reference).deductions;
  ASSERT_GE(found.size(), 3U);
  for (size_t i = 1; i < found.size(); ++i) {
    EXPECT_LT(std::pair(found[i - 1].mistake, found[i - 1].left),
              std::pair(found[i].mistake, found[i].left));
  }
}

}  // namespace
}  // namespace enamel::scoring
