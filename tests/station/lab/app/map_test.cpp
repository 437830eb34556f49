#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/json.hpp>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "station/lab/app/qualify.h"

namespace enamel::station::lab {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

json::value RowsOf(const std::string& profile) {
  fs::path path = fs::temp_directory_path() / ("enamel-map-" + std::to_string(getpid()) + ".json");
  QualifyOptions o;
  o.profile = profile;
  o.suites = {"map"};
  o.json_path = path;
  EXPECT_EQ(RunQualify(o), 0);
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  fs::remove(path);
  return json::parse(text.str()).at("rows");
}

// Whether within 7 % and 15 ms, read from a row.
bool Fine(const json::object& row, const std::string& of) {
  const json::value& delay = row.at(of + (row.at("motion") == "steady" ? "rise_s" : "lag_s"));
  return row.at(of + "error").to_number<double>() <= 0.07 && !delay.is_null() &&
         delay.to_number<double>() <= 0.015;
}

TEST(MapSuiteTest, EveryRowHasItsFiguresAndTheVerdictThatFollows) {
  const json::value rows = RowsOf("omega3");
  // By the profile and as attached, six tissues, four speeds, two motions.
  ASSERT_EQ(rows.as_array().size(), 2u * 6 * 4 * 2);
  std::set<double> speeds, stiffness;
  for (const json::value& value : rows.as_array()) {
    const json::object& row = value.as_object();
    EXPECT_EQ(row.at("suite"), "map");
    EXPECT_EQ(row.at("device"), "omega3");
    speeds.insert(row.at("speed_mm_per_s").to_number<double>());
    stiffness.insert(row.at("kc_n_per_mm").to_number<double>());
    EXPECT_EQ(row.at("attached").as_bool(), row.at("delay_ticks") == 1);
    bool steady = row.at("motion") == "steady";
    EXPECT_EQ(row.at("lag_s").is_null(), steady);
    double error = row.at("error").to_number<double>();
    // Of the Omega, peak and continuous: 12 N.
    double rms = row.at("right_rms_n").to_number<double>(),
           most = row.at("right_largest_n").to_number<double>();
    std::string expected = rms > 12 || most > 12  ? "beyond_force"
                           : Fine(row, "")        ? "felt"
                           : error <= 0.07        ? "late"
                           : error <= 0.19        ? "nearly"
                           : Fine(row, "oracle_") ? "law_falls_short"
                                                  : "device_cannot";
    EXPECT_EQ(row.at("verdict").as_string(), expected) << json::serialize(row);
  }
  EXPECT_EQ(speeds.size(), 4u);
  EXPECT_EQ(stiffness, (std::set<double>{3, 10}));
}

}  // namespace
}  // namespace enamel::station::lab
