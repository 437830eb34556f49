#include "station/lab/app/qualify.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

namespace fs = std::filesystem;

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("enamel-qualify-" + std::to_string(getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string ReadAll(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream out;
  out << in.rdbuf();
  return out.str();
}

TEST(QualifyTest, RefusesUnknownProfilesAndSuitesWithWhatIsKnown) {
  QualifyOptions o;
  std::string text;
  o.errors = [&](const std::string& why) { text += why + "\n"; };
  o.profile = "no-such-device";
  EXPECT_EQ(RunQualify(o), 1);
  o.profile = "omega3";
  o.suites = {"nonsense"};
  EXPECT_EQ(RunQualify(o), 1);
  EXPECT_NE(text.find("phantom_desktop"), std::string::npos);
  EXPECT_NE(text.find("estimators"), std::string::npos);
  o.suites = {"hand"};
  o.motion = "/nowhere/at/all";
  EXPECT_EQ(RunQualify(o), 1)
      << "generated motions give other figures: nobody who names a folder wants them";
  EXPECT_NE(text.find("found none in /nowhere/at/all"), std::string::npos) << text;
}

TEST(QualifyTest, TakesAProfileOfOnesOwnAndRefusesOneThatIsNotPassiveWithTheKcThatIs) {
  Folder folder;
  scene::DeviceProfile profile = scene::BuiltinProfiles()[1];
  profile.name = "bench_top";
  fs::path path = folder.path() / "profile.json";
  QualifyOptions o;
  o.profile = path;
  o.suites = {"random"};
  o.cases = 4;
  o.json_path = folder.path() / "rows.json";
  std::string text;
  o.errors = [&](const std::string& why) { text += why + "\n"; };
  std::ofstream(path) << scene::ToJson(profile);
  EXPECT_EQ(RunQualify(o), 0);
  EXPECT_NE(ReadAll(o.json_path).find("bench_top"), std::string::npos);
  // 2 b / T = 3500 N/m, but friction of 25 mN allows 2 c / delta = 5000 N/m: the smaller counts.
  profile.coupling_mn_per_mm.value = 3600;
  std::ofstream(path) << scene::ToJson(profile);
  EXPECT_EQ(RunQualify(o), 1);
  std::ofstream(path) << "{\"format\": 1";
  EXPECT_EQ(RunQualify(o), 1);
  o.profile = folder.path() / "absent.json";
  EXPECT_EQ(RunQualify(o), 1);
  EXPECT_NE(text.find("3500"), std::string::npos) << text;
  EXPECT_NE(text.find("absent.json"), std::string::npos) << text;
}

TEST(QualifyTest, RefusesATorqueThatIsNotPassiveAndAFileItCannotWriteBeforeItMeasures) {
  Folder folder;
  auto all = scene::BuiltinProfiles();
  auto six =
      std::find_if(all.begin(), all.end(), [](const auto& p) { return p.torque.has_value(); });
  ASSERT_NE(six, all.end());
  fs::path path = folder.path() / "six.json";
  QualifyOptions o;
  o.profile = path;
  o.suites = {"random"};
  o.cases = 1;
  std::string text;
  o.errors = [&](const std::string& why) { text += why + "\n"; };
  std::ofstream(path) << scene::ToJson(*six);
  EXPECT_EQ(RunQualify(o), 0) << text;
  six->torque->coupling_un_m_per_rad.value *= 1000;
  std::ofstream(path) << scene::ToJson(*six);
  EXPECT_EQ(RunQualify(o), 1);
  EXPECT_NE(text.find("torque/coupling_un_m_per_rad"), std::string::npos) << text;
  o.profile = "omega3";
  o.cases = 1'000'000;  // hours, if it began
  o.json_path = folder.path() / "absent" / "rows.json";
  EXPECT_EQ(RunQualify(o), 1);
  EXPECT_NE(text.find("--json: cannot write"), std::string::npos) << text;
}

// Every documented member of the rows, and a report of the same suites.
TEST(QualifyTest, WritesRowsAndAReport) {
  Folder folder;
  QualifyOptions o;
  o.profile = "omega3";
  o.suites = {"random", "adversary", "estimators"};
  o.quick = true;
  o.cases = 6;
  o.adversary_ticks = 100'000;
  o.json_path = folder.path() / "rows.json";
  o.report = folder.path() / "report";
  EXPECT_EQ(RunQualify(o), 0);
  auto json = boost::json::parse(ReadAll(o.json_path)).as_object();
  const auto& rows = json.at("rows").as_array();
  ASSERT_EQ(rows.size(), 96u);  // four draws of six, each in four hands
  for (const char* name :
       {"device", "b_n_s_per_mm", "rate_hz", "on_board", "kc_n_per_mm", "hand_n_per_mm", "motion",
        "lattice", "delay_ticks", "proved", "felt_error", "felt_error_rms", "felt_error_95",
        "maxwell_error", "ripple_n", "pull_n", "cycles"}) {
    EXPECT_TRUE(rows[0].as_object().contains(name)) << name;
  }
  const auto document =
      boost::json::parse(ReadAll(folder.path() / "report/qualification.json")).as_object();
  EXPECT_EQ(document.at("rows"), json.at("rows"));
  EXPECT_EQ(document.at("report"), json.at("report"));
  std::set<std::string> titles;
  for (const auto& section : document.at("report").at("sections").as_array())
    titles.insert(std::string(section.at("title").as_string()));
  EXPECT_EQ(titles, (std::set<std::string>{"Random cases, one parameter set", "Adversary",
                                           "Velocity estimators"}));
  EXPECT_EQ(document.at("report").at("sources").as_array().size(), 1u);  // of the one device
}

TEST(QualifyTest, GivesTheSameRowsForTheSameSeed) {
  Folder folder;
  std::string seen[2];
  for (int i : {0, 1}) {
    QualifyOptions o;
    o.profile = "phantom_desktop";
    o.suites = {"random"};
    o.cases = 5;
    o.threads = 1 + i;
    o.seed = 77;
    o.json_path = folder.path() / "rows.json";
    ASSERT_EQ(RunQualify(o), 0);
    seen[i] = ReadAll(o.json_path);
  }
  EXPECT_EQ(seen[0], seen[1]);
}

// One quantity at the bad end of its interval, the others as measured.
TEST(CalibrationSuiteTest, TellsTheKcThatIsSafeAtTheBadEndOfEachInterval) {
  const std::string path =
      std::string(ENAMEL_SOURCE_DIR) + "/schemas/golden/scene_calibration.json";
  Result<scene::Calibration> calibration = CalibrationIn(path);
  ASSERT_TRUE(calibration.ok());
  const scene::DeviceProfile phantom = scene::BuiltinProfiles()[1];
  ASSERT_EQ(phantom.name, calibration->profile);
  const Table t = BadEnds(phantom, *calibration);
  // b 1750 +- 60, c 25 +- 2, m 45 +- 2, delta 10000, delay 0, f1 96 +- 12: and Kc 2.5 N/mm.
  ASSERT_EQ(t.rows.size(), 8u);
  auto Kc = [&](size_t row) { return std::stod(t.rows[row][3]); };
  // m (2 pi f1/4)^2 = 0.045 (151)^2 = 1.02 N/mm limits all of them: f1 is what to measure better.
  const double mode = 0.045 * std::pow(M_PI / 2 * 96, 2) * 1e-3;
  EXPECT_NEAR(Kc(0), mode, 0.01);
  EXPECT_EQ(t.rows[0][4], "mode");
  EXPECT_NEAR(Kc(3), mode * 43 / 45, 0.01);
  EXPECT_NEAR(Kc(6), mode * std::pow(84.0 / 96, 2), 0.01);
  EXPECT_LE(Kc(7), Kc(6));
  EXPECT_EQ(t.rows[7][5], "NOT SAFE");
}

TEST(CalibrationSuiteTest, RefusesTheCalibrationOfAnotherDevice) {
  QualifyOptions o;
  std::string text;
  o.errors = [&](const std::string& why) { text += why; };
  o.profile = "omega3";
  o.suites = {"calibration"};
  o.calibration = std::string(ENAMEL_SOURCE_DIR) + "/schemas/golden/scene_calibration.json";
  EXPECT_EQ(RunQualify(o), 1);
  EXPECT_NE(text.find("phantom_desktop"), std::string::npos) << text;
}

TEST(QualifyTest, SaysWhereItCannotWrite) {
  QualifyOptions o;
  o.suites = {"estimators"};
  o.json_path = "/proc/no/rows.json";
  EXPECT_EQ(RunQualify(o), 1);
}

}  // namespace
}  // namespace enamel::station::lab
