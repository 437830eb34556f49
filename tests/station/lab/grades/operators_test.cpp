#include "station/lab/grades/operators.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>
#include <iterator>

namespace enamel::station::lab {
namespace {

TEST(OperatorsTest, SpearmanIsThatOfTheTextbook) {
  // 1 - 6 sum d^2 / (n (n^2 - 1)) with d = 1, -1, 1, -1, 0 and n = 5.
  EXPECT_NEAR(Spearman({1, 2, 3, 4, 5}, {20, 10, 40, 30, 50}), 0.8, 1e-12);
  EXPECT_NEAR(Spearman({1, 2, 3}, {9, 5, 1}), -1, 1e-12);
  // Ties share their mean rank: of 1.5, 1.5, 3 and 1, 2, 3 it is the square root of 3/4.
  EXPECT_NEAR(Spearman({7, 7, 9}, {1, 2, 3}), 0.8660254037844387, 1e-12);
  EXPECT_EQ(Spearman({4, 4}, {1, 2}), 0);
  EXPECT_EQ(Spearman({}, {}), 0);
}

TEST(OperatorsTest, TheDocumentIsTheSchemas) {
  OperatorsFindings findings;
  findings.rows = {{"class-1-x", "omega3", "hasty", 5, 12, false, 71.5}};
  findings.order = {{"class-1-x", "omega3", 1, 0}};
  findings.not_cut = {"crown-x"};
  findings.left_out = {{"cross-x", "omega3", "undercutter"}};
  std::ifstream file(ENAMEL_SOURCE_DIR "/schemas/golden/lab_operators.json");
  const std::string golden(std::istreambuf_iterator<char>(file), {});
  EXPECT_EQ(boost::json::value(OperatorsJson(findings)), boost::json::parse(golden));
}

TEST(OperatorsTest, ADeviceThatIsNotThereIsRefusedByName) {
  OperatorsOptions options;
  options.devices = {"spoon"};
  const auto findings = MeasureOperators(options);
  ASSERT_FALSE(findings.ok());
  EXPECT_EQ(findings.status().code(), Code::kNotFound);
  EXPECT_NE(findings.status().message().find("spoon"), std::string::npos);
}

}  // namespace
}  // namespace enamel::station::lab
