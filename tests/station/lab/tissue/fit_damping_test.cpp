#include "station/lab/tissue/fit_damping.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/json.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>

#include "common/fidelity/plant.h"

namespace enamel::station::lab {

using fidelity::Random;
namespace {

// A recorded cut of `seconds` at `rate`: speed swings between 0.1 and 0.4 mm/s, R = B v + noise.
std::string Cut(double b, double rate, double seconds, double noise_n, uint64_t seed,
                const char* head = "time_s,position_mm,force_n", double to_column = 1) {
  Random r(seed);
  std::string csv = std::string(head) + "\n";
  double x = 0;
  for (int i = 0; i < seconds * rate; ++i) {
    double t = i / rate, v = 0.25 + 0.15 * std::sin(2 * M_PI * 0.7 * t);
    csv += std::to_string(t) + "," + std::to_string(x * to_column) + "," +
           std::to_string(b * v + noise_n * r.Normal()) + "\n";
    x += v / rate;
  }
  return csv;
}

TEST(FitDampingTest, FindsTheDampingOfACleanCutAtAnyRate) {
  for (double rate : {40.0, 100.0, 1000.0}) {
    auto report = FitDamping(Cut(6.5, rate, 20, 0, 1));
    ASSERT_TRUE(report.ok()) << report.status().message();
    ASSERT_EQ(report->fits.size(), 1u);
    EXPECT_EQ(report->fits[0].refused, "");
    // Half a sample between the difference's middle and the force's: below 2 % of the slope at 40
    // Hz.
    EXPECT_NEAR(report->fits[0].b_n_s_per_mm, 6.5, 0.13) << rate;
    EXPECT_NEAR(report->rate_hz, rate, 0.01 * rate);
  }
}

// The 95 % interval holds the true value in about 95 % of noisy recordings: of 200, between 180 and
// 200.
TEST(FitDampingTest, IntervalCoversTheTruthAsOftenAsItSays) {
  int covered = 0;
  double widest = 0;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    auto report = FitDamping(Cut(8.7, 40, 15, 0.15, seed));
    ASSERT_TRUE(report.ok());
    const DampingFit& f = report->fits[0];
    covered += f.b_low <= 8.7 && 8.7 <= f.b_high;
    widest = std::max(widest, f.b_high - f.b_low);
  }
  EXPECT_GE(covered, 180);
  EXPECT_LT(widest, 2.0);
}

TEST(FitDampingTest, StoresAMaterialProfileOfWhatWasFittedAndNothingOfWhatWasNot) {
  std::string base = testing::TempDir() + "enamel-material-" + std::to_string(getpid());
  FitDampingOptions options{base + ".csv", "", base + ".json", ""};
  std::ofstream(options.csv_path) << Cut(6.5, 100, 20, 0.05, 3);
  EXPECT_EQ(RunFitDamping(options), 0);
  std::stringstream text;
  text << std::ifstream(options.material_path).rdbuf();
  auto document = boost::json::parse(text.str()).as_object();
  EXPECT_EQ(document.at("enamel_material"), 1);
  auto tissue = document.at("tissues").at(0).as_object();
  EXPECT_NEAR(tissue.at("damping_mn_s_per_mm").to_number<double>(), 6500, 130);
  const auto& fit = tissue.at("fit").as_object();
  EXPECT_LT(fit.at("damping_low_mn_s_per_mm").to_number<double>(), 6500);
  EXPECT_GT(fit.at("damping_high_mn_s_per_mm").to_number<double>(), 6500);
  std::filesystem::remove(options.material_path);
  std::ofstream(options.csv_path) << "time_s,position_mm,force_n\n0,0,1\n1,0,1\n2,0,1\n";
  EXPECT_EQ(RunFitDamping(options), 1);
  EXPECT_FALSE(std::filesystem::exists(options.material_path));
  std::filesystem::remove(options.csv_path);
}

TEST(FitDampingTest, MaterialProfileIsTheGoldenDocument) {
  DampingReport report;
  report.rate_hz = 40;
  DampingFit enamel;
  enamel.tissue = "enamel";
  enamel.used = 120;
  enamel.b_n_s_per_mm = 8.7;
  enamel.b_low = 6.1;
  enamel.b_high = 11.3;
  enamel.offset_n = -0.02;
  enamel.residual_rms_n = 0.15;
  DampingFit pulp;
  pulp.tissue = "pulp";
  pulp.refused = "no contact";
  report.fits = {enamel, pulp};
  std::stringstream golden;
  golden << std::ifstream(ENAMEL_SOURCE_DIR "/schemas/golden/material.json").rdbuf();
  EXPECT_EQ(MaterialText(report, "molar_cut.csv"), golden.str());
}

TEST(FitDampingTest, MaterialOfAMatrixAndOfALoadIsTheGoldenDocument) {
  DampingReport report;
  report.rate_hz = 1000;
  DampingFit enamel;
  enamel.tissue = "enamel";
  enamel.used = 210;
  enamel.b_n_s_per_mm = 6.5, enamel.b_low = 6.4, enamel.b_high = 6.6;
  enamel.offset_n = 0.5;
  enamel.residual_rms_n = 0.09;
  enamel.cut.model = CutModel::kAxialLateral;
  enamel.cut.b = {6.5, 6.4, 6.6};
  enamel.cut.axial = {9, 8.8, 9.2};
  enamel.load.emplace();
  enamel.load->exponent = cutting::FeedExponent::kHalf;
  enamel.load->feed_mm_s = 0.43;
  enamel.load->coulomb_n = {0.5, 0.47, 0.53};
  enamel.load->at_feed_n = {6.5 * 0.43, 2.7, 2.9};
  enamel.load->friction_told = true;
  enamel.load->friction = {0.48, 0.44, 0.52};
  DampingFit dentin;
  dentin.tissue = "dentin";
  dentin.used = 180;
  dentin.b_n_s_per_mm = 5.2, dentin.b_low = 5.1, dentin.b_high = 5.3;
  dentin.residual_rms_n = 0.06;
  dentin.cut.model = CutModel::kMatrix;
  dentin.cut.matrix = {Estimate{5, 4.9, 5.1}, {5.2, 5.1, 5.3},    {5.4, 5.3, 5.5},
                       {0.1, 0, 0.2},         {-0.2, -0.3, -0.1}, {0, -0.1, 0.1}};
  report.fits = {enamel, dentin};
  std::stringstream golden;
  golden << std::ifstream(ENAMEL_SOURCE_DIR "/schemas/golden/material_cut.json").rdbuf();
  EXPECT_EQ(MaterialText(report, "molar_cut.csv"), golden.str());
}

TEST(FitDampingTest, RefusesAnAxisThatIsNone) {
  for (const char* axis : {"0,0,0", "1,2", "1,2,3,4", "a,b,c"}) {
    FitDampingOptions options{"never-read.csv", "", "", axis};
    testing::internal::CaptureStderr();
    EXPECT_EQ(RunFitDamping(options), 1);
    EXPECT_NE(testing::internal::GetCapturedStderr().find("three numbers"), std::string::npos)
        << axis;
  }
}

TEST(FitDampingTest, FitsEachTissueApart) {
  std::string csv = "time_s,position_mm,force_n,tissue\n";
  double x = 0;
  for (int i = 0; i < 1600; ++i) {
    double v = 0.25 + 0.15 * std::sin(i * 0.11), b = i < 800 ? 8.7 : 5.2;
    csv += std::to_string(i / 40.0) + "," + std::to_string(x) + "," + std::to_string(b * v) + "," +
           (i < 800 ? "enamel" : "\"dentin, hard\"") + "\n";
    x += v / 40;
  }
  auto report = FitDamping(csv);
  ASSERT_TRUE(report.ok());
  ASSERT_EQ(report->fits.size(), 2u);
  EXPECT_NEAR(report->fits[0].b_n_s_per_mm, 8.7, 0.2);
  EXPECT_EQ(report->fits[1].tissue, "dentin, hard");
  EXPECT_NEAR(report->fits[1].b_n_s_per_mm, 5.2, 0.12);
  const auto drawn = boost::json::parse(DampingPlot(*report, "cut.csv")).at("report");
  const auto& series = drawn.at("sections").at(0).at("plots").at(0).at("series").as_array();
  ASSERT_EQ(series.size(), 4u);  // each tissue's windows and line
  EXPECT_TRUE(series[3].at("label").as_string().starts_with("dentin, hard: B = 5."));
  const auto& line = series[3].as_object();
  EXPECT_NEAR((line.at("y").at(1).to_number<double>() - line.at("y").at(0).to_number<double>()) /
                  line.at("x").at(1).to_number<double>(),
              report->fits[1].b_n_s_per_mm, 1e-3);
}

TEST(FitDampingTest, TakesThreeAxesAndMetres) {
  std::string csv = "t_ms,x_m,y_m,z_m,fx_n,fy_n,fz_n\n";
  double s = 0;
  for (int i = 0; i < 2000; ++i) {
    double v = 0.25 + 0.15 * std::sin(i * 0.03);
    csv += std::to_string(i * 10) + ",";
    char line[200];
    std::snprintf(line, sizeof line, "%.9f,0,%.9f,%.6f,0,%.6f\n", 0.6e-3 * s, 0.8e-3 * s,
                  6.5 * v * 0.6, 6.5 * v * 0.8);
    csv += line;
    s += v * 0.01;
  }
  auto report = FitDamping(csv);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_NEAR(report->fits[0].b_n_s_per_mm, 6.5, 0.1);
}

TEST(FitDampingTest, SaysWhichUnitItTookWhereTheNameDoesNotSay) {
  auto report = FitDamping(Cut(6.5, 40, 20, 0, 1, "time,position,force", 1e-3));
  ASSERT_TRUE(report.ok());
  ASSERT_FALSE(report->notes.empty());
  EXPECT_NE(report->notes[0].find("metres"), std::string::npos);
}

struct Refusal {
  const char* name;
  std::string csv;
  const char* reason;
};

std::string Rows(const std::function<std::string(int)>& row,
                 const char* head = "time_s,position_mm,force_n") {
  std::string csv = std::string(head) + "\n";
  for (int i = 0; i < 400; ++i) csv += row(i) + "\n";
  return csv;
}

TEST(FitDampingTest, RefusesWithTheReasonWhatCannotBeFitted) {
  auto S = [](double v) { return std::to_string(v); };
  const Refusal files[] = {
      {"empty", "", "empty"},
      {"no force column", "time_s,position_mm\n0,0\n", "force_n"},
      {"no numbers", "time_s,position_mm,force_n\na,b,c\n", "rows of numbers"},
      {"time falls", Rows([&](int i) { return S(i % 7 * 0.1) + ",0,1"; }), "time does not rise"},
      {"kilometres", Rows([&](int i) { return S(i / 40.0) + "," + S(i * 1e4) + ",1"; }),
       "check the unit"},
      {"kilonewtons", Rows([&](int i) { return S(i / 40.0) + "," + S(i * 0.01) + ",2800"; }),
       "largest force"},
      {"milliseconds as seconds",
       Rows([&](int i) { return S(i * 25.0) + "," + S(i * 0.01) + ",1"; }), "unit of time"},
      {"open quote", "time_s,position_mm,force_n\n\"0", "never closed"},
  };
  for (const Refusal& f : files) {
    auto report = FitDamping(f.csv);
    ASSERT_FALSE(report.ok()) << f.name;
    EXPECT_NE(report.status().message().find(f.reason), std::string::npos)
        << f.name << ": " << report.status().message();
  }
  const Refusal tissues[] = {
      {"no motion", Rows([&](int i) { return S(i / 40.0) + ",1,2"; }), "no motion"},
      {"no contact", Rows([&](int i) { return S(i / 40.0) + "," + S(i * 0.01) + ",0.001"; }),
       "no contact"},
      {"too short", Cut(6.5, 40, 0.6, 0, 1), "windows"},
      {"falls with speed", Rows([&](int i) {
         return S(i / 40.0) + "," + S(i * 0.01 + 0.05 * std::sin(i * 0.1)) + "," +
                S(3 - 2 * std::cos(i * 0.1));
       }),
       "falls with speed"},
  };
  for (const Refusal& f : tissues) {
    auto report = FitDamping(f.csv);
    ASSERT_TRUE(report.ok()) << f.name << report.status().message();
    EXPECT_NE(report->fits[0].refused.find(f.reason), std::string::npos)
        << f.name << ": " << report->fits[0].refused;
  }
}

}  // namespace
}  // namespace enamel::station::lab
