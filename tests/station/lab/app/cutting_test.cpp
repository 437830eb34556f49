#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "station/lab/app/qualify.h"

namespace enamel::station::lab {
namespace {

namespace fs = std::filesystem;

std::string ReadAll(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream out;
  out << in.rdbuf();
  return out.str();
}

// One run serves all claims: it measures.
class CuttingSuiteTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("enamel-cutting-" + std::to_string(getpid()));
    fs::create_directories(folder_);
    QualifyOptions o;
    o.suites = {"cutting"};
    o.quick = true;
    o.json_path = folder_ / "rows.json";
    o.report = folder_ / "report";
    exit_code_ = RunQualify(o);
    const auto document = boost::json::parse(ReadAll(o.json_path));
    for (const auto& row : document.at("rows").as_array())
      (row.at("suite").as_string() == "order" ? orders_ : rows_).push_back(row);
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static double Number(const boost::json::value& row, const char* name) {
    return row.at(name).to_number<double>();
  }

  static inline fs::path folder_;
  static inline int exit_code_ = -1;
  static inline boost::json::array rows_, orders_;
};

TEST_F(CuttingSuiteTest, RowsCarryErrorAndRunTimeOfEveryVoxelSize) {
  ASSERT_EQ(exit_code_, 0);
  ASSERT_EQ(rows_.size(), 4u);  // two burs, two voxel sizes
  for (const auto& row : rows_) {
    EXPECT_EQ(row.at("suite").as_string(), "cutting");
    EXPECT_GT(Number(row, "mean_us"), 0);
    EXPECT_GT(Number(row, "p99_us"), 0);
    EXPECT_GT(Number(row, "surface_p95_um"), Number(row, "surface_mean_um"));
    EXPECT_LT(std::abs(Number(row, "volume_error")), 0.02);
    EXPECT_NEAR(Number(row, "removed_mm3") / Number(row, "analytic_mm3") - 1,
                Number(row, "volume_error"), 1e-9);
  }
}

TEST_F(CuttingSuiteTest, OrderOfEveryQuantityHasAnIntervalAndAFloorWhereItDoesNotFall) {
  std::map<std::string, int> rows;
  for (const auto& row : orders_) {
    const std::string method(row.at("method").as_string());
    ++rows[method];
    if (method == "cutting") {
      EXPECT_EQ(row.at("way").as_string(), "groove");
    }
    const auto& rms = row.at("rms").as_array();
    ASSERT_EQ(rms.size(), row.at("steps").as_array().size());
    ASSERT_GE(rms.size(), 2u);
    const double coarse = rms[rms.size() - 2].to_number<double>(),
                 fine = rms.back().to_number<double>();
    EXPECT_NEAR(Number(row, "order"), std::log2(coarse / fine), 1e-9);
    EXPECT_LE(row.at("interval").at(0).to_number<double>(), Number(row, "order"));
    EXPECT_GE(row.at("interval").at(1).to_number<double>(), Number(row, "order"));
    EXPECT_EQ(row.at("floor").is_null(), Number(row, "order") >= 0.9);
  }
  // Two burs, three quantities.
  EXPECT_EQ(rows,
            (std::map<std::string, int>{
                {"cutting", 6}, {"meshes", 2}, {"pictures", 1}, {"plants", 4}, {"scores", 4}}));
}

// Surface nets put a vertex within h^2/R of a sphere. The integrator is of second order; the energy that damping takes
// is summed over its steps by rectangles.
TEST_F(CuttingSuiteTest, MeshesFallWithTheSquareAndSimulatedDevicesWithTheStep) {
  for (const auto& row : orders_) {
    const std::string method(row.at("method").as_string());
    const std::string what(row.at("what").as_string()), quantity(row.at("quantity").as_string());
    if (method == "meshes" || method == "pictures") {
      EXPECT_NEAR(Number(row, "order"), 2, 0.1) << quantity;
    }
    if (method == "plants" && what.find("in a hand") != std::string::npos) {
      EXPECT_NEAR(Number(row, "order"), quantity == "energy" ? 1 : 2, 0.05) << quantity;
    }
    // Planes, which 16 bits meet to 1/8192 of a voxel of 100 um: 0.012 um.
    const double finest = row.at("rms").as_array().back().to_number<double>();
    if (quantity == "wall offset" || quantity == "floor depth") EXPECT_LT(finest, 0.0125);
    if (quantity == "wall angle") EXPECT_LT(finest, 0.01);
    if (quantity == "energy put in") EXPECT_FALSE(row.at("converged_from").is_null());
  }
}

TEST_F(CuttingSuiteTest, EveryBurHasAFrontAndItsMostExactRowIsOnIt) {
  std::map<std::string, const boost::json::value*> best;
  for (const auto& row : rows_) {
    auto& seen = best[std::string(row.at("bur").as_string())];
    if (!seen || Number(row, "surface_p95_um") < Number(*seen, "surface_p95_um")) seen = &row;
  }
  EXPECT_EQ(best.size(), 2u);
  for (const auto& [bur, row] : best) EXPECT_TRUE(row->at("pareto").as_bool()) << bur;
}

TEST_F(CuttingSuiteTest, ReportHasTheFrontAndTheErrorsOfEveryBurWithTheirOrder) {
  const auto document = boost::json::parse(ReadAll(folder_ / "report/qualification.json"));
  const auto& sections = document.at("report").at("sections").as_array();
  ASSERT_EQ(sections.size(), 1u);
  EXPECT_EQ(sections[0].at("title").as_string(), "Cutting: error against run time");
  const auto& plots = sections[0].at("plots").as_array();
  ASSERT_EQ(plots.size(), 4u);  // the front; volume, surface, force
  for (const auto& plot : plots) {
    const auto& series = plot.at("series").as_array();
    const auto named = std::find_if(series.begin(), series.end(), [](const auto& one) {
      return one.at("label").as_string().starts_with("cylinder r 0.6 x 4 mm");
    });
    ASSERT_NE(named, series.end()) << plot.at("title");
    EXPECT_FALSE(named->at("x").as_array().empty());
  }
}

}  // namespace
}  // namespace enamel::station::lab
