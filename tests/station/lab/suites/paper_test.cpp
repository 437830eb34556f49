#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <set>

#include "station/lab/report/report.h"
#include "station/lab/suites/suite_paper.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

// As printed: N, and in the order of the paper's tables.
const std::vector<double> kTable3 = {3.7, 0.8, 1.1};

DeviceModel Paper(size_t i) {
  auto model = ModelOf(ShippedProfiles().at(i));
  EXPECT_TRUE(model.ok());
  return *model;
}

// Nothing in eq. 17 stops at table 3's force: the force is Kc times the distance, to within two
// counts.
TEST(PaperTable3Test, TheLimiterPassesThePrintedForceAfterFOverKcAndGoesOn) {
  for (size_t i = 0; i < 3; ++i) {
    DeviceModel m = Paper(i);
    double way = kTable3[i] / m.kc_n_per_m, count = m.kc_n_per_m * m.resolution_m;
    EXPECT_NEAR(LimiterForceAfter(m, way), kTable3[i], 2 * count) << m.name;
    EXPECT_NEAR(LimiterForceAfter(m, 2 * way), 2 * kTable3[i], 2 * count) << m.name;
  }
}

// Figure 8: 2.6 N within 0.1 N at 0.4 mm/s, so B is 6.25 to 6.75 N s/mm. Table 3: 3.7 N at more
// than 2 mm/s, so B is at most 1.85, or 0.411 where one count in a tick is the least speed.
TEST(PaperTable3Test, NoDampingGivesBothTable3AndFigure8) {
  DeviceModel omega = Paper(0);
  Table3Says says = ArithmeticOfTable3(3.7, omega.kc_n_per_m, omega.resolution_m, omega.tick_s());
  EXPECT_DOUBLE_EQ(says.largest_b_n_s_per_m, 1850);
  EXPECT_NEAR(says.largest_b_of_count_n_s_per_m, 411, 1);
  EXPECT_NEAR(says.force_at_figure_8_n, 0.74, 1e-9);
  EXPECT_LT(says.largest_b_n_s_per_m, (2.6 - 0.1) / 0.4e-3);
}

// The ceiling by counts is what the simulation gives: R = B delta / T where one tick has one count.
TEST(PaperTable3Test, BelowOneCountATickTheLimitersCeilingIsOneCountsForce) {
  DeviceModel omega = Paper(0);
  for (double b : {20.0, 100.0}) {
    TrialSpec s = SpecOf(omega, haptics::LawKind::kPaperLimited, b, 2e-3);
    s.settle_s = 0.5;
    s.window_s = 0.2;
    s.measure_release = false;
    EXPECT_NEAR(RunTrial(s).mean_n, b * omega.resolution_m / omega.tick_s(), 1e-9) << b;
  }
}

TEST(PaperTable3Test, ThePrintedForcesAreInProportionToNoDeviceFigure) {
  std::vector<double> kc, k, peak;
  for (size_t i = 0; i < 3; ++i) {
    DeviceModel m = Paper(i);
    kc.push_back(m.kc_n_per_m);
    k.push_back(m.max_stiffness_n_per_m);
    peak.push_back(m.peak_force_n);
  }
  EXPECT_DOUBLE_EQ(SpreadOf(kc, kc), 1);
  EXPECT_NEAR(SpreadOf(kTable3, kc), (3.7 / 10) / (1.1 / 4), 1e-12);  // .37, .32, .275 mm
  EXPECT_GT(SpreadOf(kTable3, k), 1.3);
  EXPECT_GT(SpreadOf(kTable3, peak), 1.3);
}

TEST(PaperTable3Test, RaisingDampingUntilTheDeviceVibratesDoesNotGiveThePrintedForces) {
  for (const LimiterReading& reading : LimiterReadings()) {
    if (reading.law != haptics::LawKind::kPaperLimited) continue;
    std::vector<double> force;
    for (size_t i = 0; i < 3; ++i)
      force.push_back(RaiseUntilItVibrates(Paper(i), reading, 10e-3).force_n);
    EXPECT_GT(SpreadOf(kTable3, force), 1.35) << reading.label;  // Kc alone does better
  }
}

TEST(PaperSuiteTest, DrawsTheFiguresOfTheOmegaWithThePapersLevelsInThePapersSection) {
  QualifyOptions options;
  Findings findings;
  findings.models = {Paper(0)};
  SuiteContext context{options, findings, [](const char*, size_t, size_t) {}};
  RunPaperSuite(context);
  std::set<std::string> frames;
  size_t levels = 0;
  for (const TimeTrace& t : findings.traces) {
    frames.insert(t.title.substr(0, 8));
    levels += t.label.rfind("paper: ", 0) == 0;
    EXPECT_GE(t.samples.size(), 2u) << t.title << t.label;
  }
  EXPECT_EQ(frames, (std::set<std::string>{"Figure 7", "Figure 8", "Figure 9"}));
  EXPECT_EQ(levels, 3u);
  const boost::json::object report = ReportOf(findings);
  const boost::json::object* paper = nullptr;
  for (const auto& section : report.at("sections").as_array()) {
    if (section.at("title").as_string().starts_with("The paper")) paper = &section.as_object();
  }
  ASSERT_NE(paper, nullptr);
  std::set<std::string> plots;
  for (const auto& plot : paper->at("plots").as_array())
    plots.insert(std::string(plot.at("title").as_string()).substr(0, 18));
  EXPECT_TRUE(plots.contains("Figure 8, 0.4 mm/s"))
      << boost::json::serialize(*paper).substr(0, 200);
}

}  // namespace
}  // namespace enamel::station::lab
