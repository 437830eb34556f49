#include <gtest/gtest.h>

#include <limits>

#include "station/lab/suites/extreme_cases.h"

namespace enamel::station::lab {
namespace {

struct Suite {
  QualifyOptions options;
  Findings findings;
  SuiteContext context{options, findings, [](const char*, size_t, size_t) {}};

  explicit Suite(double of_kc = 1) {
    options.quick = true;
    DeviceModel omega = *ModelOf(ShippedProfiles().at(0));
    omega.kc_n_per_m *= of_kc;
    findings.models = {omega};
  }
  size_t Failed() const {
    size_t n = 0;
    for (const ExtremeRow& r : findings.extremes) n += r.Passed() ? 0 : 1;
    return n;
  }
};

TEST(ExtremeTest, ARowPassesBetweenItsBoundsAndWithinThePeak) {
  ExtremeRow r;
  r.unit = "N";
  r.least = 1;
  r.most = 2;
  r.found = 1.5;
  EXPECT_FALSE(r.Passed());
  r.within_peak = true;
  EXPECT_TRUE(r.Passed());
  for (double found : {0.99, 2.01, std::numeric_limits<double>::quiet_NaN()}) {
    r.found = found;
    EXPECT_FALSE(r.Passed()) << found;
  }
  EXPECT_EQ(r.Expected(), "1 to 2 N");
  r.least = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(r.Expected(), "at most 2 N");
}

TEST(ExtremeTest, EventsComeOutAsTheyMust) {
  Suite s;
  AddEvents(s.findings.models[0], &s.findings.extremes);
  EXPECT_EQ(s.findings.extremes.size(), 9u);
  for (const ExtremeRow& r : s.findings.extremes)
    EXPECT_TRUE(r.Passed()) << r.name << ": " << r.Expected() << ", found " << r.Found();
}

TEST(ExtremeTest, TheLargestVoxelOfEachBurKeepsTheForceWithinTenPercent) {
  std::vector<ExtremeRow> rows;
  AddVoxelLimits(&rows);
  EXPECT_EQ(rows.size(), BurCases().size());
  for (const ExtremeRow& r : rows)
    EXPECT_TRUE(r.Passed()) << r.name << ": " << r.Expected() << ", found " << r.Found();
}

TEST(ExtremeTest, TimingAndMarginsHoldAtTheProfilesKcAndAreLostAtEightTimesIt) {
  Suite at_profile, stiff(8);
  for (Suite* s : {&at_profile, &stiff}) AddTiming(s->context);
  EXPECT_EQ(at_profile.Failed(), 0u);
  EXPECT_GT(stiff.Failed(), 0u);
  AddMargins(at_profile.context);
  EXPECT_EQ(at_profile.Failed(), 0u);
  const Table& margins = at_profile.findings.tables.back();
  ASSERT_EQ(margins.rows.size(), 7u);
  EXPECT_EQ(margins.rows[0].front(), "Omega 3DOF");
  EXPECT_EQ(margins.rows[0].back(), "passive");   // b x 8
  EXPECT_EQ(margins.rows[4].back(), "unstable");  // delay x 8: 7 ticks
}

}  // namespace
}  // namespace enamel::station::lab
