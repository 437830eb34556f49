#include "common/scoring/movement/series.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cmath>

namespace enamel::scoring {
namespace {

namespace json = boost::json;

core::CoreParams Params() {
  core::CoreParams p;
  p.peak_force_mn = 6000;
  p.soft_start_ticks = 100;
  return p;
}

core::TickOutput Output(double force_n, double x_mm, int64_t enamel_units) {
  core::TickOutput out;
  out.force_sent_n = out.force_computed_n = dvec3(0, -force_n, 0);
  out.anchor.tip_m = dvec3(x_mm * 1e-3, 0, 1e-3);
  out.removed[1] = enamel_units;
  return out;
}

json::object Json(const SeriesRecorder& series) { return json::parse(series.ToJson()).as_object(); }
double At(const json::object& o, const char* name, size_t i) {
  return o.at(name).as_array().at(i).to_number<double>();
}

TEST(SeriesRecorderTest, EveryTickIsAStepWhenThereAreFew) {
  SeriesRecorder series(Params(), 50e-6, 3);
  for (int i = 0; i < 3; ++i) series.Add({}, Output(i, i, 65536));
  json::object o = Json(series);
  EXPECT_EQ(o.at("step_ticks").as_int64(), 1);
  EXPECT_EQ(o.at("rate_hz").as_int64(), 1000);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(At(o, "t_s", i), 0.001 * static_cast<double>(i), 1e-9);
    EXPECT_NEAR(At(o, "force_n", i), static_cast<double>(i), 1e-9);
    EXPECT_NEAR(At(o, "removed_mm3", i), 1.25e-4 * static_cast<double>(i + 1), 1e-6);
    EXPECT_NEAR(At(o, "bound_n", i), 6, 1e-9);
    EXPECT_NEAR(o.at("anchor_mm").at(i).at(0).to_number<double>(), static_cast<double>(i), 1e-9);
    EXPECT_NEAR(o.at("anchor_mm").at(i).at(2).to_number<double>(), 1, 1e-9);
  }
  const json::object& tissues = o.at("removed_by_tissue").as_object();
  EXPECT_EQ(tissues.size(), 1u) << "only what was cut";
  EXPECT_EQ(tissues.at("enamel"), o.at("removed_mm3"));
}

TEST(SeriesRecorderTest, ForceIsWhatTheHandFeelsWithoutTouchCues) {
  SeriesRecorder series(Params(), 50e-6, 1);
  core::TickOutput out = Output(1.3, 0, 0);
  out.force_computed_n = dvec3(0, -1, 0);
  series.Add({}, out);
  EXPECT_NEAR(At(Json(series), "force_n", 0), 1, 1e-9);
}

TEST(SeriesRecorderTest, AStepHasTheDirectionOfItsLargestForceAndWhatCameLate) {
  SeriesRecorder series(Params(), 50e-6, 4000);  // two ticks a step
  trace::Tick late;
  late.input.flags = core::kLateTick;
  core::TickOutput weak = Output(1, 0, 0), strong = Output(2, 0, 0);
  strong.force_sent_n = dvec3(0, 0, 2);
  strong.force_computed_n = dvec3(3, 0, 4);
  strong.flags = haptics::kPeakBounded;
  series.Add(late, strong);
  series.Add({}, weak);
  series.Add({}, weak);
  const json::object o = Json(series);
  EXPECT_EQ(o.at("force_vector_n"), json::parse("[[0,0,2],[0,-1,0]]"));
  EXPECT_EQ(o.at("computed_n"), json::parse("[5,1]"));
  EXPECT_EQ(o.at("late_ticks"), json::parse("[1,0]"));
  EXPECT_EQ(o.at("force_n"), json::parse("[2,1]"));
}

TEST(SeriesRecorderTest, HowFarThePulpIsComesFromWhereTheTipIs) {
  SeriesRecorder series(Params(), 50e-6, 2);
  series.Add({}, Output(1, 2, 0));
  series.Add({}, Output(1, 3, 0));
  EXPECT_FALSE(Json(series).contains("pulp_mm"));
  const auto text = series.ToJson([](const dvec3& tip_m) { return 2 * tip_m.x; });
  EXPECT_EQ(json::parse(text).at("pulp_mm"), json::parse("[4,6]"));
}

TEST(SeriesRecorderTest, LongAttemptsHaveAtMostTwoThousandSteps) {
  SeriesRecorder series(Params(), 50e-6, 600'000);
  for (int i = 0; i < 600'000; ++i) series.Add({}, Output(i % 300 == 7 ? 3 : 1, 0, 0));
  json::object o = Json(series);
  ASSERT_EQ(o.at("t_s").as_array().size(), 2000u);
  EXPECT_EQ(o.at("step_ticks").as_int64(), 300);
  EXPECT_NEAR(At(o, "force_n", 1000), 3, 1e-9) << "the largest, not a sample";
  EXPECT_NEAR(At(o, "force_mean_n", 1000), 302.0 / 300, 0.6e-3);
  EXPECT_NEAR(At(o, "t_s", 1999), 599.7, 1e-9);
}

TEST(SeriesRecorderTest, GapsMoveTheTimeAndTheBoundIsZeroWhileForceIsOff) {
  SeriesRecorder series(Params(), 50e-6, 4);
  for (int i = 0; i < 2; ++i) series.Add({}, Output(0, 0, 0));
  trace::Tick after_gap;
  after_gap.input.gap_ticks = 10;
  core::TickOutput reset = Output(0, 0, 0);
  reset.flags = core::kAnchorReset | core::kSuspended;
  series.Add(after_gap, reset);
  series.Add({}, Output(0, 0, 0));
  json::object o = Json(series);
  EXPECT_NEAR(At(o, "t_s", 2), 0.012, 1e-9);
  EXPECT_NEAR(At(o, "bound_n", 1), 6, 1e-9);
  EXPECT_EQ(At(o, "bound_n", 2), 0);
  EXPECT_NEAR(At(o, "bound_n", 3), 6, 1e-9);
}

TEST(SeriesRecorderTest, AnEmptyAttemptIsEmptyLists) {
  json::object o = Json(SeriesRecorder(Params(), 50e-6, 0));
  EXPECT_TRUE(o.at("t_s").as_array().empty());
  EXPECT_TRUE(o.at("removed_by_tissue").as_object().empty());
}

}  // namespace
}  // namespace enamel::scoring
