#include <gtest/gtest.h>

#include <cmath>

#include "common/trace/replay.h"
#include "station/lab/cutting/attempt.h"
#include "station/lab/cutting/cutting_error.h"

// The benchmarks measure what they name. No test here depends on a time.
namespace enamel::station::lab {
namespace {

constexpr double kPi = 3.14159265358979323846;

CuttingPlan Plan(std::vector<CutCase> cases, std::vector<int32_t> voxels_nm) {
  CuttingPlan plan;
  plan.cases = std::move(cases);
  plan.voxels_nm = std::move(voxels_nm);
  plan.ticks = 100;
  plan.replays = 1;
  return plan;
}

TEST(TickCostTest, BurIsEngagedInEveryMeasuredTickAndReplaysAgree) {
  for (Sunk sunk : {Sunk::kHalf, Sunk::kWhole, Sunk::kLying}) {
    CutCase c;
    c.voxel_nm = 100'000;
    c.sunk = sunk;
    TickCost cost = TimeTicks(MakeCutPath(c, 200), 2);
    EXPECT_EQ(cost.ticks, 200u);
    EXPECT_EQ(cost.engaged_share, 1) << SunkName(sunk);
    EXPECT_TRUE(cost.replays_agree);
  }
}

// 5 mm/s for 0.2 s is 1 mm of a slot 1.2 mm wide: 2 mm deep upright, 0.6 mm deep and 4 mm wide
// lying.
TEST(TickCostTest, RemovesWhatTheWayIsLong) {
  CutCase c;
  c.voxel_nm = 50'000;
  EXPECT_NEAR(TimeTicks(MakeCutPath(c, 200), 1).removed_mm3, 1.2 * 2 * 1, 0.02 * 2.4);
  c.sunk = Sunk::kLying;
  EXPECT_NEAR(TimeTicks(MakeCutPath(c, 200), 1).removed_mm3, 0.6 * 4 * 1, 0.02 * 2.4);
}

TEST(TickCostTest, SpreadIsMeanAndNinetyNinthPercentile) {
  std::vector<double> values;
  for (int i = 1; i <= 1000; ++i) values.push_back(i);
  Spread spread = SpreadOf(values);
  EXPECT_DOUBLE_EQ(spread.mean, 500.5);
  EXPECT_DOUBLE_EQ(spread.p99, 991);
  EXPECT_EQ(SpreadOf({}).mean, 0);
}

// The integral over the outline is compared with closed forms of the shapes that have one.
TEST(CuttingErrorTest, SweptVolumeMeetsTheClosedForms) {
  CutCase cylinder, ball;
  cylinder.oblique = ball.oblique = true;
  ball.bur = {cutting::BurShape::kSphere, 0.5e-3, 0};
  auto figures = MeasureCutting(Plan({cylinder, ball}, {100'000}));
  ASSERT_EQ(figures.size(), 2u);
  // The anchor ends at X: 0.3 s of settling and 0.1 s measured at 5 mm/s after the entry.
  double x = 1.1 + 0.4 * 5, r = 0.6, depth = 2;
  EXPECT_NEAR(figures[0].analytic_mm3, (2 * r * x + 0.5 * kPi * r * r) * depth, 0.02);
  // Half a ball of radius R: 2 X times its half disc, and half of half its volume.
  x = 1.0 + 0.4 * 5;
  r = 0.5;
  EXPECT_NEAR(figures[1].analytic_mm3, 2 * x * 0.25 * kPi * r * r + kPi * r * r * r / 3, 0.02);
}

TEST(CuttingErrorTest, EveryBurIsWithinAPercentOfItsSweptVolumeAndAVoxelOfItsSurface) {
  auto plan = Plan(BurCases(), {100'000});
  for (CutCase& c : plan.cases) c.oblique = true;
  auto figures = MeasureCutting(plan);
  ASSERT_EQ(figures.size(), 7u);
  for (const CuttingFigures& f : figures) {
    EXPECT_LT(std::fabs(f.volume_error), 0.02) << BurText(f.c);
    EXPECT_GT(f.vertices, 100u) << BurText(f.c);
    EXPECT_LT(f.deviation_p95_um, 100) << BurText(f.c);
    EXPECT_LT(f.deviation_mean_um, f.deviation_p95_um) << BurText(f.c);
    EXPECT_GT(f.force_mean_n, 0) << BurText(f.c);
  }
}

TEST(CuttingErrorTest, FinerVoxelIsCloserToTheBody) {
  CutCase c;
  c.oblique = true;
  auto figures = MeasureCutting(Plan({c}, {100'000, 50'000}));
  ASSERT_EQ(figures.size(), 2u);
  EXPECT_LT(figures[1].deviation_mean_um, 0.6 * figures[0].deviation_mean_um);
  EXPECT_EQ(figures[1].force_error, 0);
  EXPECT_GT(figures[0].force_error, 0);
}

AttemptOptions ShortAttempt() {
  AttemptOptions options;
  options.voxel_nm = 100'000;
  options.ticks = 20'000;
  return options;
}

TEST(AttemptTest, IsARecordingThatReplaysTickByTick) {
  auto attempt = RecordAttempt(ShortAttempt());
  ASSERT_TRUE(attempt.ok()) << attempt.status().message();
  EXPECT_EQ(attempt->seal.ticks, 20'000u);
  EXPECT_GT(attempt->cutting_share, 0.15);
  EXPECT_LT(attempt->cutting_share, 0.6);
  core::Core core(attempt->header.params, attempt->built.volume);
  auto report = trace::Replay(core, attempt->header, attempt->chunks);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_TRUE(report->witness_ok) << report->what;
  EXPECT_EQ(report->state_hash, attempt->seal.state_hash);
}

// To a voxel, here the coarsest.
TEST(AttemptTest, WallsCutTooDeepOnPurposeAreScoredAsThat) {
  auto scores = MeasureScores({100'000}, 20'000);
  ASSERT_TRUE(scores.ok()) << scores.status().message();
  bool mesial = false;
  for (const CriterionFigures& c : scores->at(0).criteria) {
    if (c.metric == "wall_mesial_mm") {
      mesial = true;
      EXPECT_NEAR(c.value, kMesialExtra_m * 1e3, 0.1);
    }
    if (c.metric == "wall_distal_mm") {
      EXPECT_NEAR(c.value, 0, 0.1);
    }
  }
  EXPECT_TRUE(mesial);
}

}  // namespace
}  // namespace enamel::station::lab
