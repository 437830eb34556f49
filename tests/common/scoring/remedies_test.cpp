#include "common/scoring/remedies.h"

#include <gtest/gtest.h>

#include "common/scoring/reasons.h"

// What an instructor would call each fault, and what he would tell the student to do. Written down
// from the faults, not from the table.
namespace enamel::scoring {
namespace {

using Map = std::vector<scene::RubricPoint>;
const Map kWithin = {{-0.3, 0}, {-0.05, 1}, {0.05, 1}, {0.3, 0}}, kAtMost = {{1, 1}, {3, 0}},
          kAtLeast = {{50, 0}, {90, 1}}, kBetween = {{4, 0}, {6, 1}, {12, 1}, {20, 0}};

struct Case {
  const char *metric, *fault, *remedy;
  double value;
  const Map* map;
  bool above = true;
};
const Case kCases[] = {
    {"wall_distal_mm", "over_extended", "stop_earlier", 0.2, &kWithin},
    {"wall_distal_mm", "under_extended", "cut_further", -0.2, &kWithin, false},
    {"floor_mm", "too_deep", "stop_earlier", 0.2, &kWithin},
    {"floor_mm", "too_shallow", "cut_further", -0.2, &kWithin, false},
    {"tilt_buccal_deg", "over_tapered", "do_parallel", 0.2, &kWithin},
    {"tilt_buccal_deg", "undercut", "do_upright", -0.2, &kWithin, false},
    {"wall_tilt_deg", "walls_inclined", "do_parallel", 2, &kAtMost},
    {"undercut_deg", "undercut", "do_upright", 2, &kAtMost},
    {"tilt_floor_deg", "floor_slopes", "do_level", 2, &kAtMost},
    {"wall_waviness_mm", "wall_wavy", "do_even_wall", 2, &kAtMost},
    {"floor_waviness_mm", "floor_uneven", "do_even_floor", 2, &kAtMost},
    {"deepest_over_mm", "gouge", "stop_earlier", 2, &kAtMost},
    {"left_standing_mm3", "left_standing", "cut_further", 2, &kAtMost},
    {"caries_left_percent", "caries_left", "cut_further", 2, &kAtMost},
    {"outside_removed_mm3", "cut_elsewhere", "stop_earlier", 2, &kAtMost},
    {"neighbour_depth_mm", "neighbour_cut", "do_guard", 2, &kAtMost},
    {"task_done_percent", "unfinished", "cut_further", 60, &kAtLeast, false},
    {"finish_complete_percent", "finish_line_missing", "do_finish_all_around", 60, &kAtLeast,
     false},
    {"convergence_mesiodistal_deg", "over_tapered", "do_taper_less", 15, &kBetween},
    {"convergence_mesiodistal_deg", "undercut", "do_taper_more", 5, &kBetween, false},
    {"reduction_top_mm", "over_reduced", "stop_earlier", 15, &kBetween},
    {"reduction_top_mm", "under_reduced", "cut_further", 5, &kBetween, false},
    {"finish_width_mm", "finish_line_narrow", "do_finish_wider", 5, &kBetween, false},
    {"force_sent_p95_n", "heavy_hand", "do_lighter", 2, &kAtMost},
};

std::vector<Deduction> Everywhere(const char* metric) {
  Deduction over, left;
  over.criterion = left.criterion = metric;
  over.volume_m3 = over.strokes_m3 = 1e-9;
  over.strokes = {{3, 1000, 1, 2, 1e-9}};
  // The larger one: it must not decide what is advised.
  left.left = true;
  left.volume_m3 = 5e-9;
  return {over, left};
}

TEST(RemediesTest, EachFaultIsCalledByItsNameAndMendedByItsKind) {
  for (const Case& c : kCases) {
    const MetricInfo& info = *FindMetric(c.metric);
    const Remedy* remedy = FindRemedy(c.metric, c.above);
    ASSERT_NE(remedy, nullptr) << c.metric;
    EXPECT_EQ(remedy->fault, c.fault) << c.metric << " " << c.value;
    const auto advice = Advice(info, c.value, *c.map, Everywhere(c.metric));
    ASSERT_TRUE(advice) << c.metric;
    EXPECT_EQ(advice->code, c.remedy) << c.metric << " " << c.value;
    const std::string said = Sentence("It", info, {*advice}, "");
    EXPECT_GT(said.size(), 10U) << c.metric;
    EXPECT_TRUE(said.ends_with(".") && !said.ends_with("..")) << said;
  }
}

TEST(RemediesTest, WhatIsRightHasNoFaultAndTimeHasNoRemedy) {
  const MetricInfo &wall = *FindMetric("wall_distal_mm"), &time = *FindMetric("time_s");
  EXPECT_FALSE(Advice(wall, 0.05, kWithin, Everywhere("wall_distal_mm")));
  EXPECT_FALSE(Advice(time, 2, kAtMost, Everywhere("time_s")));
}

// A shape that is off is advised where most of it is off: here, where too much was left.
TEST(RemediesTest, AMetricThatDoesNotTellTheSidesApartIsAdvisedWhereMostIsWrong) {
  const MetricInfo& rms = *FindMetric("deviation_rms_mm");
  std::vector<Deduction> places = Everywhere("deviation_rms_mm");
  EXPECT_EQ(Advice(rms, 2, kAtMost, places)->code, "cut_further");
  places[0].volume_m3 = 6e-9;
  EXPECT_EQ(Advice(rms, 2, kAtMost, places)->code, "stop_earlier");
  EXPECT_EQ(
      Advice(*FindMetric("within_300um_percent"), 60, kAtLeast, Everywhere("within_300um_percent"))
          ->code,
      "cut_further");
}

TEST(RemediesTest, AFaultWithoutAPlaceIsNotSentToOne) {
  EXPECT_FALSE(Advice(*FindMetric("floor_mm"), 0.2, kWithin, {}));
  EXPECT_TRUE(Advice(*FindMetric("tilt_floor_deg"), 2, kAtMost, {}));
}

}  // namespace
}  // namespace enamel::scoring
