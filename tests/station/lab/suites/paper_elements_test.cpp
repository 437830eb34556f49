#include "station/lab/suites/paper_elements.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <filesystem>
#include <fstream>
#include <set>

#include "station/lab/report/paper_page.h"

namespace enamel::station::lab {
namespace {

std::string FileText(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

const std::vector<PaperElement>& All() {
  static const std::vector<PaperElement> all = PaperElements({});
  return all;
}

const PaperElement& Of(const std::vector<PaperElement>& all, const std::string& element) {
  for (const PaperElement& e : all)
    if (e.element == element) return e;
  ADD_FAILURE() << element;
  return all.front();
}

TEST(PaperElementsTest, ThirtyWithVerdictRemarkAndCommand) {
  std::set<std::string> names;
  for (const PaperElement& e : All()) {
    names.insert(e.element);
    EXPECT_FALSE(e.printed.empty() || e.ours.empty() || e.says.empty()) << e.element;
    EXPECT_TRUE(e.command.starts_with("enamel-lab ")) << e.element;
    EXPECT_EQ(e.remark.empty(), e.verdict == PaperVerdict::kReproduced) << e.element;
  }
  EXPECT_EQ(All().size(), 30u);
  EXPECT_EQ(names.size(), 30u);
  for (int i = 1; i <= 17; ++i) EXPECT_TRUE(names.contains("equation " + std::to_string(i))) << i;
}

TEST(PaperElementsTest, VerdictsOfThePaper) {
  EXPECT_EQ(Of(All(), "equation 1").verdict, PaperVerdict::kReproduced);
  EXPECT_EQ(Of(All(), "equation 15").verdict, PaperVerdict::kContradicts);
  EXPECT_EQ(Of(All(), "equation 16").verdict, PaperVerdict::kRemark);
  EXPECT_EQ(Of(All(), "equation 17").verdict, PaperVerdict::kContradicts);
  EXPECT_EQ(Of(All(), "table 1, Omega 3DOF").verdict, PaperVerdict::kNotReproducible);
  EXPECT_EQ(Of(All(), "table 2, Phantom Desktop").verdict, PaperVerdict::kContradicts);
  EXPECT_EQ(Of(All(), "table 2, BHhd 3DOF").verdict, PaperVerdict::kRemark);
  EXPECT_EQ(Of(All(), "table 3, Omega 3DOF").verdict, PaperVerdict::kContradicts);
  EXPECT_EQ(Of(All(), "figure 8").verdict, PaperVerdict::kRemark);
}

// A verdict is computed: with other numbers it is another.
TEST(PaperElementsTest, AnotherPrintedFigureGetsAnotherVerdict) {
  PrintedPaper p;
  p.devices[0].table2_computed_n_s_per_mm = 0.012;
  p.devices[1].table1_b_n_s_per_mm = p.devices[1].table2_measured_n_s_per_mm;
  p.tissues[0].force_n = 6;
  p.figure8_error_n = 1e-6;
  p.devices[2].table1_force_n = 0.001;
  const std::vector<PaperElement> other = PaperElements(p);
  EXPECT_EQ(Of(other, "equation 16").verdict, PaperVerdict::kNotReproducible);
  EXPECT_EQ(Of(other, "table 2, Omega 3DOF").verdict, PaperVerdict::kNotReproducible);
  EXPECT_EQ(Of(other, "table 2, Phantom Desktop").verdict, PaperVerdict::kRemark);
  EXPECT_EQ(Of(other, "measured cutting").verdict, PaperVerdict::kContradicts);
  EXPECT_EQ(Of(other, "figure 8").verdict, PaperVerdict::kNotReproducible);
  EXPECT_EQ(Of(other, "table 1, BHhd 3DOF").verdict, PaperVerdict::kRemark);
}

// Equations 5 to 9 with rounding to the nearest count: half of each bound, and reached.
TEST(PaperElementsTest, RoundingReachesHalfOfThePapersBounds) {
  const RoundingErrors r = ErrorsOfRounding(9e-6, 1000, 0.4e-3);
  EXPECT_LE(r.position, 0.5 + 1e-9);
  EXPECT_GT(r.position, 0.49);
  EXPECT_LE(r.step, 1 + 1e-9);
  EXPECT_GT(r.step, 0.9);
  // Below a count a tick it does not alternate, so that a force's change reaches a quarter.
  EXPECT_NEAR(r.change, 1, 0.1);
  EXPECT_NEAR(r.at_rest, 1 - 0.4 / 9, 1e-3);  // a count in 22.5 ticks
}

TEST(PaperElementsTest, TheChangeOfSpeedEntersEquation11Once) {
  for (double change : {1e-4, 1e-3, 0.1})
    EXPECT_NEAR(FactorOfSpeedChange(9e-6, 1000, change), 1, 1e-9);
}

TEST(PaperElementsTest, TheNumbersAreThePapers) {
  const std::string path = ENAMEL_SHARED_DATA "/../reference/paper_tables.json";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "skipped: no shared data";
  const boost::json::value paper = boost::json::parse(FileText(path));
  auto Number = [&](const std::string& pointer) {
    return paper.at_pointer(pointer).to_number<double>();
  };
  const PrintedPaper p;
  for (const PrintedDevice& d : p.devices) {
    const std::string name = d.profile;
    EXPECT_EQ(d.resolution_mm, Number("/devices/" + name + "/resolution_mm"));
    EXPECT_EQ(d.max_stiffness_n_per_mm, Number("/devices/" + name + "/max_stiffness_N_per_mm"));
    EXPECT_EQ(d.table1_b_n_s_per_mm,
              Number("/table1_without_limiter/" + name + "/max_damping_N_s_per_mm"));
    EXPECT_EQ(d.table1_force_n, Number("/table1_without_limiter/" + name + "/max_force_N"));
    EXPECT_EQ(d.table2_measured_n_s_per_mm,
              Number("/table2/" + name + "/measured_max_damping_N_s_per_mm"));
    EXPECT_EQ(d.table2_computed_n_s_per_mm,
              Number("/table2/" + name + "/computed_by_eq16_N_s_per_mm"));
    EXPECT_EQ(d.table3_kc_n_per_mm, Number("/table3_with_limiter/" + name + "/kc_N_per_mm"));
    EXPECT_EQ(d.table3_force_n, Number("/table3_with_limiter/" + name + "/max_continuous_force_N"));
  }
  for (const PrintedTissue& t : p.tissues) {
    const std::string name = t.name;
    EXPECT_EQ(t.force_n, Number("/measured_cutting/max_force_N/" + name));
    EXPECT_EQ(t.least_b_n_s_per_mm,
              Number("/measured_cutting/damping_abs_N_s_per_mm/" + name + "/0"));
    EXPECT_EQ(t.most_b_n_s_per_mm,
              Number("/measured_cutting/damping_abs_N_s_per_mm/" + name + "/1"));
  }
  EXPECT_EQ(p.speed_mm_per_s, Number("/measured_cutting/max_operating_speed_mm_s"));
  EXPECT_EQ(p.b_n_s_per_mm, Number("/measured_cutting/chosen_damping_N_s_per_mm"));
}

// enamel-lab paper --markdown docs/paper.md
TEST(PaperPageTest, ThePageInDocsIsTodays) {
  EXPECT_EQ(FileText(ENAMEL_SOURCE_DIR "/docs/paper.md"), PaperMarkdown({}, All()));
}

TEST(PaperPageTest, TheDocumentIsTheSchemas) {
  const PaperElement element = {"equation 16",    "B <= K T / 2",    "0.006 N s/mm",
                                "0.00600 N s/mm", "a = 0",           PaperVerdict::kRemark,
                                "V drops out.",   "enamel-lab paper"};
  EXPECT_EQ(boost::json::value(PaperJson({&element, 1})),
            boost::json::parse(FileText(ENAMEL_SOURCE_DIR "/schemas/golden/lab_paper.json")));
}

}  // namespace
}  // namespace enamel::station::lab
