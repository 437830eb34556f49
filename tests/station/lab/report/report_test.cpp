#include "station/lab/report/report.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/json.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <string>

#include "station/lab/report/draw.h"
#include "station/lab/report/plot.h"

namespace enamel::station::lab {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

std::string ReadAll(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream out;
  out << in.rdbuf();
  return out.str();
}

json::value Schema(const std::string& file) {
  return json::parse(ReadAll(fs::path(ENAMEL_SOURCE_DIR) / "schemas" / file));
}

// One of every kind of content of a report.
Findings OneOfEach() {
  Findings f;
  f.quick = true;
  f.models.emplace_back();
  f.models[0].name = "device";
  f.models[0].title = "Device & co";
  f.models[0].provenance = {{"Kc", "Liu et al. 2008"}};
  Attack attack;
  attack.law = "law";
  attack.ticks = 2'000'000;
  attack.violations = 1;
  attack.proved = true;
  f.attacks.push_back(attack);
  RandomSummary random;
  random.title = "speeds <uniform>";
  random.cases = 3;
  random.held = 2;
  random.errors = {0.005, 0.0125, 0.0025};
  random.ripples_n = {0.05, 0.1, 0.025};
  f.random.push_back(random);
  f.tables.push_back({"Adversary: games", "A note.", {"law", "floor"}, {{"law", "UNDER 1 nJ"}}});
  f.maps.push_back({"Map",
                    "B, N s/mm",
                    "delay, ticks",
                    "A map's note.",
                    {1, 10},
                    {1, 2},
                    {Verdict::kPassive, Verdict::kUnstable, Verdict::kBounded, Verdict::kStable},
                    {{"theory", {{1, 1}, {10, 2}}}}});
  return f;
}

// Web tests read the same file (web/src/api/lab_report.test.ts).
TEST(LabReportTest, IsTheGoldenDocument) {
  const std::string found = json::serialize(json::object{{"report", ReportOf(OneOfEach())}}) + "\n";
  EXPECT_EQ(found, ReadAll(fs::path(ENAMEL_SOURCE_DIR) / "schemas/golden/lab_report.json"));
}

void CheckNames(const json::value& value, const json::object& schema, const json::object& defs,
                const std::string& where) {
  if (const auto* ref = schema.if_contains("$ref")) {
    constexpr size_t kPrefix = sizeof("#/$defs/") - 1;
    return CheckNames(value, defs.at(ref->as_string().subview(kPrefix)).as_object(), defs, where);
  }
  if (const auto* known = schema.if_contains("enum")) {
    const auto& all = known->as_array();
    EXPECT_NE(std::find(all.begin(), all.end(), value), all.end()) << where << ": " << value;
  }
  if (value.is_array()) {
    for (const auto& one : value.as_array())
      CheckNames(one, schema.at("items").as_object(), defs, where + "/items");
  }
  if (!value.is_object()) return;
  std::set<std::string> found, required;
  for (const auto& member : value.as_object()) found.insert(std::string(member.key()));
  for (const auto& name : schema.at("required").as_array())
    required.insert(std::string(name.as_string()));
  EXPECT_EQ(found, required) << where;
  for (const auto& member : value.as_object()) {
    CheckNames(member.value(), schema.at("properties").at(member.key()).as_object(), defs,
               where + "/" + std::string(member.key()));
  }
}

TEST(LabReportTest, HasTheMembersAndWordsOfItsSchema) {
  const json::value schema = Schema("lab_report.schema.json");
  CheckNames(ReportOf(OneOfEach()), schema.as_object(), schema.at("$defs").as_object(), "report");
}

TEST(LabReportTest, CellThatDoesNotHoldIsMarkedAndACardSaysSo) {
  const json::object report = ReportOf(OneOfEach());
  for (const auto& section : report.at("sections").as_array()) {
    if (section.at("title").as_string() != "Adversary") continue;
    EXPECT_EQ(section.at("tables").at(0).at("bad"), (json::array{json::array{0, 1}}));
  }
  EXPECT_EQ(report.at("cards").at(0).at("figure").as_string(), "1");
  EXPECT_FALSE(report.at("cards").at(0).at("good").as_bool());
}

TEST(PlotTest, LongSeriesKeepsItsPeaksAndIsDrawnFromLeftToRight) {
  Plot plot{.title = "p", .x_label = "t", .y_label = "f"};
  Series s{.label = "wave"};
  for (int i = 0; i < 50'000; ++i) s.points.push_back({i, std::sin(i * 0.01)});
  s.points[31'234].second = 7;
  s.points[12'345].second = -9;
  plot.series.push_back(s);
  const json::object out = PlotJson(plot);
  const auto& x = out.at("series").at(0).at("x").as_array();
  const auto& y = out.at("series").at(0).at("y").as_array();
  ASSERT_EQ(x.size(), y.size());
  EXPECT_LE(x.size(), 1000u);
  double low = 0, high = 0;
  for (size_t i = 0; i < y.size(); ++i) {
    low = std::min(low, y[i].to_number<double>());
    high = std::max(high, y[i].to_number<double>());
    if (i > 0) {
      EXPECT_GT(x[i].to_number<double>(), x[i - 1].to_number<double>());
    }
  }
  EXPECT_EQ(low, -9);
  EXPECT_EQ(high, 7);
}

TEST(PlotTest, WhatNoAxisCanShowIsLeftOut) {
  Plot plot{.title = "p", .log_x = true, .log_y = true};
  plot.series.push_back({.label = "s",
                         .points = {{0, 1},
                                    {1, -1},
                                    {2, std::numeric_limits<double>::infinity()},
                                    {3, std::nan("")},
                                    {4, 5}}});
  const json::object out = PlotJson(plot);
  EXPECT_EQ(json::serialize(out.at("series").at(0).at("x")), "[4E0]");
}

class DrawTest : public testing::Test {
 protected:
  DrawTest() : folder_(fs::temp_directory_path() / ("enamel-draw-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~DrawTest() override { fs::remove_all(folder_); }

  const fs::path folder_;
};

TEST_F(DrawTest, PageHasItsDocumentBesideItAndAFolderHasBoth) {
  EXPECT_EQ(ReportFilesOf("a/omega.html").document, "a/omega.json");
  EXPECT_EQ(ReportFilesOf("a/omega.html").page, "a/omega.html");
  EXPECT_EQ(ReportFilesOf("a/omega").document, "a/omega/qualification.json");
  EXPECT_EQ(ReportFilesOf("a/omega").page, "a/omega/report.html");
}

TEST_F(DrawTest, PlaceThatCannotBeWrittenIsRefusedBeforeTheWork) {
  EXPECT_EQ(CheckReport(folder_ / "none" / "r.html", "--report").code(), Code::kStorage);
  EXPECT_TRUE(CheckReport(folder_ / "r.html", "--report").ok());
  EXPECT_TRUE(CheckReport(folder_ / "new", "--report").ok());
}

// With node and the built script a page; without one of them the document, and a message with the
// remedy.
TEST_F(DrawTest, DocumentIsAlwaysWrittenAndAPageOrTheWayToOne) {
  const std::string document = json::serialize(json::object{{"report", ReportOf(OneOfEach())}});
  testing::internal::CaptureStderr();
  const Status written = WriteReport(document, folder_ / "r.html");
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(written.ok()) << written.message();
  EXPECT_EQ(ReadAll(folder_ / "r.json"), document);
  if (!fs::exists(folder_ / "r.html")) {
    EXPECT_NE(said.find("is written but not drawn"), std::string::npos) << said;
    GTEST_SKIP() << "skipped: no node, or the page was not built";
  }
  EXPECT_EQ(said, "");
  const std::string page = ReadAll(folder_ / "r.html");
  EXPECT_NE(page.find("<title>Qualification: Device &amp; co, quick, seed 1</title>"),
            std::string::npos);
  for (const char* outside : {"<link", "src=\"http", "@import"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
}

TEST(TextTableTest, AlignsColumns) {
  Table t{"title", "", {"a", "bb"}, {{"long cell", "x"}, {"s", "y"}}};
  EXPECT_EQ(TextOf(t), "title\na          bb\nlong cell  x\ns          y\n\n");
}

}  // namespace
}  // namespace enamel::station::lab
