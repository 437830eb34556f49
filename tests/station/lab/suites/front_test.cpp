#include "station/lab/suites/front.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <tuple>

#include "station/lab/report/report.h"

namespace enamel::station::lab {
namespace {

Row Cut(const char* law, double ns, double error_n, double rise, double release) {
  Row r;
  r.suite = "laws";
  r.profile = "device";
  r.law = law;
  r.estimator = "own";
  r.hand = "velocity";
  r.b_n_s_per_mm = 6.5;
  r.ns_per_tick = ns;
  r.tau_s = 0.5;
  r.m.ticks = 1;
  r.m.error_max_n = error_n;
  r.m.rise90_floor_s = 0.5;
  r.m.rise90_s = rise * 0.5;
  r.m.release10_s = release * 0.5;
  return r;
}

const LawPoint& Named(const std::vector<LawPoint>& points, const std::string& name) {
  for (const LawPoint& p : points) {
    if (p.name == name) return p;
  }
  ADD_FAILURE() << name;
  return points.at(0);
}

// Cheap and as accurate, but slow to rise and to let go: it beats the expensive law on the front of
// steady error, but not over all figures.
TEST(FrontTest, ALawThatRisesAndReleasesFasterIsNotDominatedByACheaperOneOfEqualError) {
  auto points =
      LawPointsOf({Cut("cheap", 20, 0.045, 2.4, 2.3), Cut("dear", 120, 0.045, 1.1, 0.3)}, "device");
  ASSERT_EQ(points.size(), 2u);
  const LawPoint& dear = Named(points, "dear");
  EXPECT_FALSE(dear.on_front[0]);
  EXPECT_TRUE(dear.on_front[1]);
  EXPECT_TRUE(dear.on_front[2]);
  EXPECT_TRUE(dear.undominated);
  EXPECT_TRUE(Named(points, "cheap").undominated);
}

TEST(FrontTest, ALawWorseInEverythingIsDominatedAndOneThatCyclesDominatesNothing) {
  std::vector<Row> rows = {Cut("good", 20, 0.04, 1.1, 0.3), Cut("bad", 30, 0.05, 1.2, 0.4),
                           Cut("wild", 10, 0.01, 1.0, 0.1)};
  rows[2].m.cycle = true;
  auto points = LawPointsOf(rows, "device");
  EXPECT_TRUE(Named(points, "good").undominated);
  EXPECT_FALSE(Named(points, "bad").undominated);
  EXPECT_FALSE(Named(points, "wild").undominated);
  EXPECT_TRUE(Named(points, "wild").lost);
}

TEST(FrontTest, TheWorstHandCountsAndOnlyAVelocityHandTimesALaw) {
  std::vector<Row> rows = {Cut("law", 20, 0.04, 1.1, 0.3), Cut("law", 20, 0.09, 9, -1)};
  rows[1].hand = "force";
  auto points = LawPointsOf(rows, "device");
  ASSERT_EQ(points.size(), 1u);
  EXPECT_DOUBLE_EQ(points[0].figures[0], 0.09);
  EXPECT_DOUBLE_EQ(points[0].figures[1], 1.1);
  EXPECT_DOUBLE_EQ(points[0].figures[2], 0.3);
}

TEST(FrontTest, WhatIsNeverReachedIsOnNoFront) {
  auto points =
      LawPointsOf({Cut("stuck", 10, 0.01, 1.1, -2), Cut("free", 20, 0.02, 1.1, 0.3)}, "device");
  EXPECT_TRUE(std::isinf(Named(points, "stuck").figures[2]));
  EXPECT_FALSE(Named(points, "stuck").on_front[2]);
  EXPECT_TRUE(Named(points, "free").on_front[2]);
}

// A suite of motions only has to provide rows: no trial of ours, no nanoseconds, another name.
TEST(FrontTest, MetricsOfAnotherSuiteJoinWhenItsRowsCarryThem) {
  std::vector<Row> rows = {Cut("cheap", 20, 0.045, 1, 0.3), Cut("dear", 120, 0.045, 1, 0.3)};
  EXPECT_FALSE(Named(LawPointsOf(rows, "device"), "dear").undominated);
  for (auto [law, error, pull] :
       {std::tuple{"cheap", 1.3, 3.8}, {"dear", 1.05, 0.2}, {"dear", 1.0, 0.4}}) {
    Row r;
    r.suite = "hand";
    r.profile = "device";
    r.law = law;
    r.estimator = "own";
    r.b_n_s_per_mm = 6.5;
    r.extra = {{"felt_error", error}, {"pull_n", pull}};
    rows.push_back(r);
  }
  auto points = LawPointsOf(rows, "device");
  const LawPoint& dear = Named(points, "dear");
  EXPECT_TRUE(dear.undominated);
  EXPECT_DOUBLE_EQ(dear.figures[3], 1.05);
  EXPECT_DOUBLE_EQ(dear.figures[4], 0.4);
  EXPECT_TRUE(dear.on_front[3]);
  Findings findings;
  findings.models.emplace_back();
  findings.models[0].name = "device";
  findings.rows = rows;
  const boost::json::object report = ReportOf(findings);
  const auto& sections = report.at("sections").as_array();
  ASSERT_EQ(sections.size(), 1u);
  const auto& plots = sections[0].at("plots").as_array();
  for (const Metric& metric : FrontMetrics()) {
    const bool drawn = std::any_of(plots.begin(), plots.end(), [&](const auto& plot) {
      return plot.at("y_label").as_string() == metric.label &&
             plot.at("title").as_string().starts_with("Against run time");
    });
    EXPECT_TRUE(drawn) << metric.id;
  }
  const std::string text = JsonOf(findings);
  EXPECT_NE(text.find("\"felt_error\":1.3"), std::string::npos);
  EXPECT_EQ(text.find("E0"), std::string::npos) << "not as people write numbers";
}

}  // namespace
}  // namespace enamel::station::lab
