#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>
#include <sstream>

#include "station/lab/report/report.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;

// One device, quick: as shipped, not calibrated and calibrated, and 8 kHz; enamel and caries.
const std::vector<FeelCurve>& OmegaCurves() {
  static const std::vector<FeelCurve> curves = [] {
    QualifyOptions options;
    options.quick = true;
    Findings findings;
    findings.models = {*ModelOf(ShippedProfiles()[0])};
    SuiteContext context{options, findings, [](const char*, size_t, size_t) {}};
    RunMapSuite(context);
    EXPECT_EQ(findings.tables.size(), 1u);
    EXPECT_EQ(findings.tables.at(0).rows.size(), findings.feel.size());
    return findings.feel;
  }();
  return curves;
}

const FeelCurve& CurveOf(const std::string& tissue, const std::string& law, double rate_hz) {
  for (const FeelCurve& c : OmegaCurves()) {
    if (c.calibrated && c.tissue == tissue && c.law == law && c.rate_hz == rate_hz) return c;
  }
  throw std::runtime_error("no curve");
}

double Grip(const FeelCurve& c, double share) {
  return fidelity::StiffestGrip(fidelity::kGrips_n_per_m, c.error, share) * 1e-3;
}

TEST(MapSuiteTest, EveryLoopTissueAndLawHasACurve) {
  ASSERT_EQ(OmegaCurves().size(), 3u * 2 * 2);
  for (const FeelCurve& c : OmegaCurves()) {
    EXPECT_EQ(c.error.size(), std::size(fidelity::kGrips_n_per_m));
    EXPECT_EQ(c.closed_form.size(), c.error.size());
    EXPECT_EQ(c.limit.empty(), c.rate_hz == 1000);
  }
}

// The law exists for this: hands that hold a device are soft.
TEST(MapSuiteTest, TheDefaultLawAndAFasterLoopReachStifferGrips) {
  const FeelCurve& law = CurveOf("enamel", "lead-maxwell", 1000);
  EXPECT_GT(Grip(law, fidelity::kViscosityShare),
            Grip(CurveOf("enamel", "maxwell", 1000), fidelity::kViscosityShare));
  EXPECT_GE(Grip(CurveOf("enamel", "lead-maxwell", 8000), fidelity::kViscosityShare),
            Grip(law, fidelity::kViscosityShare));
}

// Where the spring decides, plain Maxwell comes near its closed form, and stays below it: a generated hand
// also rests, and friction is there while the spring still lags.
TEST(MapSuiteTest, PlainMaxwellStaysNearItsClosedForm) {
  const FeelCurve& plain = CurveOf("enamel", "maxwell", 1000);
  for (size_t i = 0; i < plain.error.size(); ++i) {
    const double grip = fidelity::kGrips_n_per_m[i];
    if (grip < 1000 || grip > 5000) continue;
    EXPECT_LT(plain.error[i], plain.closed_form[i]) << grip;
    EXPECT_GT(plain.error[i], 0.5 * plain.closed_form[i]) << grip;
  }
}

// The document has the members of its schema, and no other; the golden one too.
TEST(MapSuiteTest, WritesTheDocumentOfItsSchema) {
  auto Parsed = [](const char* path) {
    std::stringstream text;
    text << std::ifstream(std::string(ENAMEL_SOURCE_DIR) + path).rdbuf();
    return json::parse(text.str()).as_object();
  };
  const json::object schema = Parsed("/schemas/feel.schema.json");
  auto SameNames = [](const json::object& found, const json::object& of) {
    EXPECT_EQ(found.size(), of.at("properties").as_object().size());
    for (const json::value& name : of.at("required").as_array())
      EXPECT_TRUE(found.contains(name.as_string())) << name;
  };
  for (const json::object& feel : {FeelJson(OmegaCurves()), Parsed("/schemas/golden/feel.json")}) {
    SameNames(feel, schema);
    const json::object& curve = feel.at("curves").as_array().at(0).as_object();
    SameNames(curve, schema.at("$defs").at("curve").as_object());
    EXPECT_EQ(curve.at("error").as_array().size(), feel.at("grips_n_per_mm").as_array().size());
  }
}

}  // namespace
}  // namespace enamel::station::lab
